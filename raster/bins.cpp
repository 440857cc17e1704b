#include "raster/bins.h"

#include <algorithm>
#include <bit>

namespace gnomon::detail {
namespace {

constexpr size_t most_listed_tiles = 64;         // of one triangle
constexpr size_t most_entries = size_t{1} << 18; // of a chunk, beyond which large triangles are kept aside

TileBox tiles_of(const SetupTriangle& t) {
    return {t.x0 >> tile_shift, t.y0 >> tile_shift, t.x1 >> tile_shift, t.y1 >> tile_shift};
}

} // namespace

TileGrid::TileGrid(const Rectangle& p, bool whole)
    : x0(p.x >> tile_shift), y0(p.y >> tile_shift), columns(((p.x + p.width - 1) >> tile_shift) - x0 + 1),
      rows(((p.y + p.height - 1) >> tile_shift) - y0 + 1), whole_pixels(whole) {}

// Lists triangles from the i-th on, until a large one, in the tiles of their boxes, at most two each way, mostly one:
// not worth asking which they touch. Returns where it ends.
size_t Chunk::add_small(size_t i) {
    const size_t room = entry_count_ + 4 * (triangles.count - i) + most_listed_tiles;
    if (entries_.size() < room) entries_.resize(room);
    const int x0 = x0_, y0 = y0_;
    const auto columns = static_cast<size_t>(x1_ - x0_ + 1);
    Entry* entry = entries_.data() + entry_count_;
    std::uint32_t* counts = begin_.data() + 2; // so that after the sums in bin() [tile + 1] is where the list begins
    const auto add = [&](size_t tile) {
        *entry++ = {static_cast<std::uint32_t>(tile), static_cast<std::uint16_t>(i)};
        ++counts[tile];
    };
    for (; i < triangles.count && triangles.data[i].extent != Extent::Large; ++i) {
        const TileBox box = tiles_of(triangles.data[i]);
        const size_t tile = static_cast<size_t>(box.y0 - y0) * columns + static_cast<size_t>(box.x0 - x0);
        add(tile);
        if (box.x1 > box.x0) add(tile + 1);
        if (box.y1 == box.y0) continue;
        add(tile + columns);
        if (box.x1 > box.x0) add(tile + columns + 1);
    }
    entry_count_ = static_cast<size_t>(entry - entries_.data());
    return i;
}

// Lists the triangle in the tiles that it touches; false, and nothing is listed, where they are too many.
bool Chunk::add_touched(const TileGrid& grid, const TileBox& box, size_t i) {
    const size_t before = entry_count_;
    for (int y = box.y0; y <= box.y1; y += 8)
        for (int x = box.x0; x <= box.x1; x += 8) {
            const int rows = std::min(box.y1 - y + 1, 8), columns = std::min(box.x1 - x + 1, 8);
            std::uint64_t touched = setup_kernels().touched_tiles(triangles.data[i], x, y, rows, grid.whole_pixels);
            touched &= (0xffull >> (8 - columns)) * 0x0101010101010101ull;
            const size_t after = entry_count_ + static_cast<size_t>(std::popcount(touched));
            if (after - before > most_listed_tiles || after > most_entries) {
                while (entry_count_ > before) --begin_[entries_[--entry_count_].tile + 2];
                return false;
            }
            for (; touched; touched &= touched - 1) {
                const int bit = std::countr_zero(touched);
                const size_t tile = local(x + (bit & 7), y + (bit >> 3));
                entries_[entry_count_++] = {static_cast<std::uint32_t>(tile), static_cast<std::uint16_t>(i)};
                ++begin_[tile + 2];
            }
        }
    return true;
}

void Chunk::bin(const TileGrid& grid) {
    const std::span<const SetupTriangle> all(triangles.data.get(), triangles.count);
    x0_ = grid.x0 + grid.columns, y0_ = grid.y0 + grid.rows, x1_ = y1_ = -1;
    for (const SetupTriangle& t : all) {
        const TileBox box = tiles_of(t);
        x0_ = std::min(x0_, box.x0), x1_ = std::max(x1_, box.x1);
        y0_ = std::min(y0_, box.y0), y1_ = std::max(y1_, box.y1);
    }
    wide_.clear();
    entry_count_ = 0;
    begin_.assign(all.empty() ? 2 : local(x1_, y1_) + 3, 0);
    for (size_t i = 0; i < all.size();) {
        i = add_small(i);
        if (i == all.size()) break;
        if (!add_touched(grid, tiles_of(all[i]), i)) wide_.push_back(static_cast<std::uint16_t>(i));
        ++i;
    }
    for (size_t i = 1; i < begin_.size(); ++i) begin_[i] += begin_[i - 1];
    if (lists_.size() < entry_count_) lists_.resize(entry_count_);
    const std::span<const Entry> entries(entries_.data(), entry_count_);
    for (const Entry& entry : entries) lists_[begin_[entry.tile + 1]++] = entry.triangle; // … and after this it ends
}

size_t Chunk::bytes() const {
    return triangles.capacity * sizeof(SetupTriangle) + triangles.pieces.capacity() * sizeof(ClippedPiece) +
           begin_.capacity() * sizeof(begin_[0]) + lists_.capacity() * sizeof(lists_[0]) +
           wide_.capacity() * sizeof(wide_[0]) + entries_.capacity() * sizeof(entries_[0]);
}

void Chunk::mark_tiles(const TileGrid& grid, size_t c, std::vector<std::uint64_t>& bits) const {
    const auto columns = static_cast<size_t>(std::max(x1_ - x0_ + 1, 0));
    for (int y = y0_; y <= y1_; ++y) {
        const std::uint32_t* begin = begin_.data() + local(x0_, y);
        std::uint64_t* row = bits.data() + grid.index(x0_, y);
        for (size_t k = 0; k < columns; ++k) row[k] |= std::uint64_t{begin[k] < begin[k + 1]} << c;
    }
    for (const std::uint16_t i : wide_) {
        const TileBox box = tiles_of(triangles.data[i]);
        for (int y = box.y0; y <= box.y1; ++y)
            for (int x = box.x0; x <= box.x1; ++x) bits[grid.index(x, y)] |= std::uint64_t{1} << c;
    }
}

std::span<const std::uint16_t> Chunk::list(int x, int y, std::vector<std::uint16_t>& merged) const {
    const size_t i = local(x, y);
    const std::span<const std::uint16_t> listed(lists_.data() + begin_[i], begin_[i + 1] - begin_[i]);
    if (wide_.empty()) return listed;
    const size_t start = merged.size();
    merged.insert(merged.end(), listed.begin(), listed.end());
    for (const std::uint16_t t : wide_)
        if (tiles_of(triangles.data[t]).contains(x, y)) merged.push_back(t);
    const auto middle = merged.begin() + static_cast<std::ptrdiff_t>(start + listed.size());
    std::inplace_merge(merged.begin() + static_cast<std::ptrdiff_t>(start), middle, merged.end());
    return std::span(merged).subspan(start);
}

std::vector<TileWork> tiles_with_work(const TileGrid& grid, std::span<const Chunk> chunks, bool all) {
    std::vector<std::uint64_t> bits(grid.count());
    for (size_t c = 0; c < chunks.size(); ++c) chunks[c].mark_tiles(grid, c, bits);
    std::vector<TileWork> work;
    work.reserve(bits.size());
    for (size_t tile = 0; tile < bits.size(); ++tile)
        if (all || bits[tile]) work.push_back({static_cast<std::uint32_t>(tile), bits[tile]});
    return work;
}

} // namespace gnomon::detail
