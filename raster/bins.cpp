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

void Chunk::add(int x, int y, size_t i) {
    const size_t tile = local(x, y);
    entries_.push_back({static_cast<std::uint32_t>(tile), static_cast<std::uint16_t>(i)});
    ++begin_[tile + 2]; // so that after the sums in bin() [tile + 1] is where the list begins
}

// Lists the triangle in the tiles that it touches; false, and nothing is listed, where they are too many.
bool Chunk::add_touched(const TileGrid& grid, const TileBox& box, size_t i) {
    const size_t before = entries_.size();
    for (int y = box.y0; y <= box.y1; ++y)
        for (int x = box.x0; x <= box.x1; x += 8) {
            std::uint32_t touched = setup_kernels().touched_tiles(triangles.data[i], x, y, grid.whole_pixels);
            if (box.x1 - x < 7) touched &= (2u << (box.x1 - x)) - 1;
            const size_t after = entries_.size() + static_cast<size_t>(std::popcount(touched));
            if (after - before > most_listed_tiles || after > most_entries) {
                while (entries_.size() > before) {
                    --begin_[entries_.back().tile + 2];
                    entries_.pop_back();
                }
                return false;
            }
            for (; touched; touched &= touched - 1) add(x + std::countr_zero(touched), y, i);
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
    entries_.clear();
    wide_.clear();
    begin_.assign(all.empty() ? 2 : local(x1_, y1_) + 3, 0);
    for (size_t i = 0; i < all.size(); ++i) {
        const TileBox box = tiles_of(all[i]);
        if (all[i].extent != Extent::Large) { // the few tiles of its box, mostly one: not worth asking which it touches
            for (int y = box.y0; y <= box.y1; ++y)
                for (int x = box.x0; x <= box.x1; ++x) add(x, y, i);
        } else if (!add_touched(grid, box, i)) {
            wide_.push_back(static_cast<std::uint16_t>(i));
        }
    }
    for (size_t i = 1; i < begin_.size(); ++i) begin_[i] += begin_[i - 1];
    lists_.resize(entries_.size());
    for (const Entry& entry : entries_) lists_[begin_[entry.tile + 1]++] = entry.triangle; // … and after this it ends
}

size_t Chunk::bytes() const {
    return triangles.capacity * sizeof(SetupTriangle) + triangles.pieces.capacity() * sizeof(ClippedPiece) +
           begin_.capacity() * sizeof(begin_[0]) + lists_.capacity() * sizeof(lists_[0]) +
           wide_.capacity() * sizeof(wide_[0]) + entries_.capacity() * sizeof(entries_[0]);
}

bool Chunk::touches_wide(int x, int y) const {
    return std::any_of(wide_.begin(), wide_.end(),
                       [&](std::uint16_t i) { return tiles_of(triangles.data[i]).contains(x, y); });
}

std::span<const std::uint16_t> Chunk::list(const TileGrid& grid, size_t tile,
                                           std::vector<std::uint16_t>& merged) const {
    const int x = grid.tile_x(tile), y = grid.tile_y(tile);
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
    for (size_t c = 0; c < chunks.size(); ++c)
        chunks[c].for_each_tile(grid, [&](size_t tile) { bits[tile] |= std::uint64_t{1} << c; });
    std::vector<TileWork> work;
    for (size_t tile = 0; tile < bits.size(); ++tile)
        if (all || bits[tile]) work.push_back({static_cast<std::uint32_t>(tile), bits[tile]});
    return work;
}

} // namespace gnomon::detail
