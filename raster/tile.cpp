#include "raster/tile.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <optional>

#include "raster/blend.h"
#include "raster/block_tests.h"
#include "raster/shading_kernels.h"

namespace gnomon::detail {
namespace {

constexpr std::uint64_t all_pixels = ~std::uint64_t{0};

// Pixels of the block at (x, y) that lie in the inclusive box.
std::uint64_t box_mask(const SetupTriangle& t, int x, int y) {
    const int x0 = std::max(t.x0 - x, 0), x1 = std::min(t.x1 - x, block_side - 1);
    const int y0 = std::max(t.y0 - y, 0), y1 = std::min(t.y1 - y, block_side - 1);
    if (x0 > x1 || y0 > y1) return 0;
    const std::uint64_t row = (0xffull >> (7 - x1)) & (0xffull << x0) & 0xff;
    const std::uint64_t rows = (all_pixels >> (8 * (7 - y1))) & (all_pixels << (8 * y0));
    return (row * 0x0101010101010101ull) & rows;
}

glm::uvec4 combined(LogicOp op, glm::uvec4 source, const Target& target, int x, int y, int layer, int level) {
    switch (op) {
    case LogicOp::Copy:
        return source;
    case LogicOp::Clear:
        return glm::uvec4(0);
    case LogicOp::Set:
        return glm::uvec4(0xffffffffu);
    case LogicOp::And:
        return source & target.load_uint(x, y, layer, level);
    case LogicOp::Or:
        return source | target.load_uint(x, y, layer, level);
    case LogicOp::Xor:
        return source ^ target.load_uint(x, y, layer, level);
    case LogicOp::Invert:
        return ~target.load_uint(x, y, layer, level);
    }
    return source;
}

bool reads_color(const PipelineState& state, const FormatInfo& format) {
    const bool integer = format.kind == FormatInfo::Kind::Uint;
    return integer ? state.logic_op >= LogicOp::And : state.blend.enabled;
}

// Colours that are stored as they are.
template <class Texel>
void write_texels(Target& target, int x, int y, int layer, int level, std::uint64_t mask, const Texel* texels) {
    const bool stream = is_streamed(target);
    for_each_row(mask, [&](int j, std::uint32_t lanes) {
        std::byte* to = target.texel(x, y + j, layer, level);
        const Texel* from = texels + block_side * j;
        constexpr size_t row_bytes = block_side * sizeof(Texel);
        if (lanes != 0xff) {
            for (; lanes; lanes &= lanes - 1) {
                const int i = std::countr_zero(lanes);
                std::memcpy(to + static_cast<int>(sizeof(Texel)) * i, from + i, sizeof(Texel));
            }
        } else if (row_bytes % 64 == 0 && stream && reinterpret_cast<std::uintptr_t>(to) % 64 == 0) {
            shading_kernels().stream(from, to, row_bytes);
        } else {
            std::memcpy(to, from, row_bytes);
        }
    });
}

// How many 32-bit channels, 1 or 4, each texel has, where they are stored as programs give them; 0 where not.
size_t plain_words(const TileDraw& tile, const Target& target, std::uint8_t channels) {
    if (tile.state->blend.enabled || tile.state->logic_op != LogicOp::Copy) return 0;
    switch (target.format()) {
    case Format::R32F:
    case Format::R32UI:
        return channels & 1 ? 1 : 0;
    case Format::RGBA32F:
        return channels == 15 ? 4 : 0;
    default:
        return 0;
    }
}

// The planes of a triangle's varyings, made when the first of its fragments asks.
struct LazyPlanes {
    const TileDraw& tile;
    const SetupTriangle& triangle;
    const ClippedPiece* pieces;
    std::optional<AttributePlanes> planes = {};

    const AttributePlanes* get() {
        if (tile.draw->varying_count == 0) return nullptr;
        if (!planes) planes = attribute_planes(tile, triangle, pieces);
        return &*planes;
    }
};

// What one sample of a block has to show: the triangle as it sees it, the pixels it covers, its layer of the targets.
struct Sample {
    const SetupTriangle* triangle;
    std::uint64_t mask;
    int layer;
};

// The fragment program on a block, its inputs and outputs.
struct Shading {
    const TileDraw& tile;
    PassCounters& counters;
    FragmentBlock block;
    const AttributePlanes* planes;

    Shading(const TileDraw& t, LazyPlanes& attributes, int x, int y, PassCounters& c)
        : tile(t), counters(c), planes(attributes.get()) {
        block.x = x, block.y = y;
        block.run = {};
        block.counters = &c;
    }
    // Runs it for the lanes; returns those that it keeps.
    std::uint64_t run(const SetupTriangle& triangle, std::uint64_t lanes, const Depths& depth) {
        const uvec3 corner = tile.draw->geometry.triangles[triangle.primitive];
        const FragmentRun run = {
            &triangle,
            planes,
            {varyings_of(tile, corner.x), varyings_of(tile, corner.y), varyings_of(tile, corner.z)},
            lanes};
        block.runs = &run;
        block.mask = block.kept = lanes;
        set_depth(run, block, depth);
        set_varyings(tile, run, block);
        counters.fragments_shaded += std::popcount(lanes);
        tile.draw->fragments(block);
        return block.kept;
    }
};

bool tests_wait(const Draw& draw) { return draw.flags.discards || draw.flags.writes_depth; }

// Tests a sample's fragments and counts those that pass. `written` is the program's own depth, or null.
std::uint64_t test_sample(const TileDraw& tile, const Sample& sample, int x, int y,
                          const std::array<float, 64>* written, PassCounters& counters) {
    const Target* target = tile.targets->depth;
    const bool fused =
        target && target->format() == Format::D32F && has_whole_rows(*target, x, tile.targets->level) && !written;
    Keys keys;
    if (target && written) {
        for_each_pixel(sample.mask, [&](int bit) {
            const auto i = static_cast<size_t>(bit);
            keys[i] = depth_key(target->format(), static_cast<double>((*written)[i]));
        });
    } else if (target && !fused) {
        Depths depth;
        tile.kernels->depth(*sample.triangle, x, y, sample.mask, depth.data());
        quantize_depth(target->format(), sample.mask, depth, keys);
    }
    const std::uint64_t passed =
        run_tests(tile, *sample.triangle, x, y, sample.layer, sample.mask, fused ? nullptr : &keys, counters);
    counters.fragments_passed += std::popcount(passed);
    return passed;
}

// A block through tests, program and blending. With several samples the program runs once a pixel, at its centre, for
// all samples that it is kept in; or, where it asks for that, once a sample, there.
void draw_block(const TileDraw& tile, const SetupTriangle& triangle, LazyPlanes& attributes, int x, int y,
                std::span<Sample> samples, PassCounters& counters) {
    const Draw& draw = *tile.draw;
    std::uint64_t any = 0;
    for (const Sample& sample : samples) {
        counters.fragments_covered += std::popcount(sample.mask);
        any |= sample.mask;
    }
    if (!draw.fragments) {
        for (const Sample& sample : samples)
            if (sample.mask) test_sample(tile, sample, x, y, nullptr, counters);
        return;
    }
    if (samples.size() > 1 && draw.flags.per_sample) {
        for (Sample& sample : samples)
            if (sample.mask) {
                counters.fragments_covered -= std::popcount(sample.mask); // counted above
                draw_block(tile, *sample.triangle, attributes, x, y, std::span(&sample, 1), counters);
            }
        return;
    }

    Shading shading(tile, attributes, x, y, counters);
    Depths depth;
    const bool late = tests_wait(draw);
    if (late) {
        tile.kernels->depth(triangle, x, y, any, depth.data());
        const std::uint64_t kept = shading.run(triangle, any, depth);
        for (Sample& sample : samples) sample.mask &= kept;
    }
    any = 0;
    for (Sample& sample : samples) {
        const std::array<float, 64>* written = draw.flags.writes_depth ? &shading.block.depth : nullptr;
        if (sample.mask) sample.mask = test_sample(tile, sample, x, y, written, counters);
        any |= sample.mask;
    }
    if (!any) return;
    if (!late) {
        tile.kernels->depth(triangle, x, y, any, depth.data());
        shading.run(triangle, any, depth);
    }
    const ColorBytes bytes = color_bytes(tile);
    for (const Sample& sample : samples) {
        if (!sample.mask) continue;
        for (size_t c = 0; c < tile.targets->color.size(); ++c)
            write_color(tile, c, x, y, sample.layer, sample.mask, shading.block.color[c]);
        counters.bytes_read += std::popcount(sample.mask) * bytes.read;
        counters.bytes_written += std::popcount(sample.mask) * bytes.written;
    }
}

} // namespace

void set_depth(const FragmentRun& run, FragmentBlock& block, const Depths& depth) {
    for_each_pixel(run.mask, [&](int bit) {
        block.depth[static_cast<size_t>(bit)] = static_cast<float>(depth[static_cast<size_t>(bit)]);
    });
}

void set_varyings(const TileDraw& tile, const FragmentRun& run, FragmentBlock& block) {
    if (!run.planes) return;
    tile.kernels->barycentrics(*run.triangle, *run.planes, block.x, block.y, run.mask, block.inverse_w.data(),
                               block.second.data(), block.third.data());
    tile.kernels->varyings(run.corners[0], run.corners[1], run.corners[2],
                           static_cast<size_t>(tile.draw->varying_count), run.mask, block.second.data(),
                           block.third.data(), block.varyings.front().data());
}

AttributePlanes attribute_planes(const TileDraw& tile, const SetupTriangle& triangle, const ClippedPiece* pieces) {
    const bool linear = tile.draw->linear_varyings;
    if (triangle.piece != SetupTriangle::whole)
        return gnomon::attribute_planes(triangle, pieces[triangle.piece], linear);
    const uvec3 index = tile.draw->geometry.triangles[triangle.primitive];
    return gnomon::attribute_planes(
        triangle, vec3(tile.positions[index.x].w, tile.positions[index.y].w, tile.positions[index.z].w), linear);
}

ColorBytes color_bytes(const TileDraw& tile) {
    ColorBytes bytes;
    for (size_t c = 0; c < tile.targets->color.size(); ++c) {
        const Target* target = tile.targets->color[c];
        if (!target || tile.state->color_mask[c] == 0) continue;
        const FormatInfo& format = info(target->format());
        bytes.written += format.bytes;
        if (reads_color(*tile.state, format)) bytes.read += format.bytes;
    }
    return bytes;
}

void write_color(const TileDraw& tile, size_t c, int x, int y, int layer, std::uint64_t mask,
                 const BlockColors::value_type& color) {
    const int level = tile.targets->level;
    Target* target = tile.targets->color[c];
    const std::uint8_t channels = tile.state->color_mask[c];
    if (!target || channels == 0) return;
    const size_t words = plain_words(tile, *target, channels);
    if (words == 1) {
        write_texels(*target, x, y, layer, level, mask, color.front().data());
        return;
    }
    if (words == 4) {
        alignas(64) std::array<vec4, block_pixels> texels;
        shading_kernels().interleave(color.data(), texels.data(), block_side);
        write_texels(*target, x, y, layer, level, mask, texels.data());
        return;
    }
    const bool integer = info(target->format()).kind == FormatInfo::Kind::Uint;
    for_each_pixel(mask, [&](int bit) {
        const int px = x + (bit & 7), py = y + (bit >> 3);
        const auto at = static_cast<size_t>(bit);
        const vec4 source(color[0][at], color[1][at], color[2][at], color[3][at]);
        if (integer) {
            const glm::uvec4 bits = glm::floatBitsToUint(source);
            target->store_uint(px, py, layer, combined(tile.state->logic_op, bits, *target, px, py, layer, level),
                               channels, level);
        } else if (tile.state->blend.enabled) {
            target->store(px, py, layer, blend(tile.state->blend, source, target->load(px, py, layer, level)), channels,
                          level);
        } else {
            target->store(px, py, layer, source, channels, level);
        }
    });
}

void draw_in_tile(const TileDraw& tile, const SetupTriangle& triangle, const ClippedPiece* pieces, int tile_x,
                  int tile_y, PassCounters& counters) {
    LazyPlanes attributes{tile, triangle, pieces};
    const std::span<const glm::ivec2> positions = sample_positions(tile.targets->samples);
    const size_t count = positions.size();
    std::array<SetupTriangle, max_samples> moved; // left alone with one sample
    std::array<TileEdges, max_samples> edges;
    std::array<Sample, max_samples> samples;
    bool empty = true;
    for (size_t s = 0; s < count; ++s) {
        if (count > 1) moved[s] = seen_by_sample(triangle, positions[s]);
        samples[s].triangle = count > 1 ? &moved[s] : &triangle;
        samples[s].layer = tile.targets->layer * static_cast<int>(count) + static_cast<int>(s);
        edges[s] = tile_edges(*samples[s].triangle, tile.state->conservative, tile_x, tile_y);
        empty = empty && edges[s].empty;
    }
    if (empty) return;
    const int x0 = std::max<int>(triangle.x0, tile_x) & ~(block_side - 1);
    const int y0 = std::max<int>(triangle.y0, tile_y) & ~(block_side - 1);
    const int x1 = std::min<int>(triangle.x1, tile_x + tile_side - 1),
              y1 = std::min<int>(triangle.y1, tile_y + tile_side - 1);
    for (int y = y0; y <= y1; y += block_side)
        for (int x = x0; x <= x1; x += block_side) {
            const int first = std::max(triangle.y0 - y, 0), last = std::min(triangle.y1 - y, block_side - 1);
            const std::uint64_t box = box_mask(triangle, x, y);
            std::uint64_t any = 0;
            for (size_t s = 0; s < count; ++s) {
                samples[s].mask =
                    edges[s].empty ? 0 : tile.kernels->coverage(edges[s], x - tile_x, y - tile_y, first, last) & box;
                any |= samples[s].mask;
            }
            if (any) draw_block(tile, triangle, attributes, x, y, std::span(samples.data(), count), counters);
        }
}

} // namespace gnomon::detail
