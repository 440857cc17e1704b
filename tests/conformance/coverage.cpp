// Coverage: stencil counts every fragment and the id target keeps the last writer, so a pixel that one side draws and
// the other does not shows in the count, and a wrong order in the id.

#include <bit>

#include <fmt/format.h>

#include "tests/conformance/explain.h"
#include "tests/conformance/triangles.h"

namespace gnomon_conformance {

bool check_coverage(const Options& options) {
    Verdict verdict("coverage");
    Random random(options.seed);
    constexpr int batch_size = 16384;
    struct Class {
        const char* name;
        Format depth;
        int side;
        bool snapped, divided;
    };
    for (const Class& c : {Class{"snapped", Format::D24, 512, true, false},
                           {"unsnapped", Format::D24, 512, false, false},
                           {"unsnapped with w", Format::D32F, 512, false, true},
                           {"odd size", Format::D24, 333, false, false}}) {
        // The viewport's multiply and add is exact for powers of two; for other sizes the witness may fuse the two.
        const bool power_of_two = std::has_single_bit(static_cast<unsigned>(c.side));
        Duel duel({.width = c.side, .height = c.side + 7 * (c.side & 1), .depth = c.depth});
        std::int64_t triangles = 0, covered = 0, counts = 0, ids = 0, unexplained = 0;
        for (int i = 0; i < options.repeat(22); ++i) {
            const Batch batch = random_batch(
                batch_size,
                {.width = duel.width(), .height = duel.height(), .snapped = c.snapped, .divided = c.divided}, random);
            duel.clear();
            PipelineState state = counting_state();
            state.viewport = wide_viewport(duel.width(), duel.height());
            duel.draw(batch, state);
            triangles += static_cast<std::int64_t>(batch.triangles.size());
            covered += duel.counters().fragments_covered;
            const Picture a = duel.ours(), b = duel.witness();
            for (size_t k = 0; k < duel.pixels(); ++k) {
                counts += a.stencil[k] != b.stencil[k];
                ids += a.ids[k] != b.ids[k];
                if (power_of_two || (a.stencil[k] == b.stencil[k] && a.ids[k] == b.ids[k])) continue;
                const auto width = static_cast<size_t>(duel.width());
                unexplained += !hangs_on_rounding(exact_vertices(batch.positions), batch.triangles, *state.viewport,
                                                  ivec2(static_cast<int>(k % width), static_cast<int>(k / width)));
            }
        }
        if (power_of_two)
            verdict.require(counts == 0 && ids == 0,
                            fmt::format("{}: {} triangles, {} covered fragments; {} pixels differ in count, {} in id",
                                        c.name, triangles, covered, counts, ids));
        else
            verdict.require(
                fraction(counts, covered) <= 1e-5 && unexplained == 0,
                fmt::format("{}: {} triangles, {} covered fragments; {} pixels differ in count ({:.1e}), {} "
                            "in id, {} not by a rounded vertex",
                            c.name, triangles, covered, counts, fraction(counts, covered), ids, unexplained));
    }
    return verdict.held();
}

bool check_stencil(const Options& options) {
    Verdict verdict("stencil");
    Random random(options.seed + 1);
    constexpr int side = 256, batch_size = 2048;
    std::int64_t wrong = 0, wrong_ids = 0, wrong_depth = 0, pixels = 0, covered = 0;
    Duel unorm({.width = side, .height = side, .depth = Format::D24});
    Duel floating({.width = side, .height = side, .depth = Format::D32F});
    const int rounds = options.repeat(200);
    for (int i = 0; i < rounds; ++i) {
        Duel& duel = i % 2 ? floating : unorm;
        // Depths k/8 are exact in every format's arithmetic, so equality can be tested for.
        PipelineState state;
        state.stencil.enabled = true;
        const bool plain = i % 4 == 0; // what stencil shadows do
        for (StencilFace* face : {&state.stencil.front, &state.stencil.back}) {
            face->test = plain ? Compare::Always : random.pick<Compare>(8);
            face->reference = random.bits() & 0xff;
            face->read_mask = random.chance(2) ? 0xff : random.bits() & 0xff;
            face->write_mask = random.chance(2) ? 0xff : random.bits() & 0xff;
            face->fail = random.pick<StencilOp>(8);
            face->depth_fail = random.pick<StencilOp>(8);
            face->pass = random.pick<StencilOp>(8);
        }
        if (plain) {
            state.stencil.front = {.depth_fail = StencilOp::DecrementWrap, .pass = StencilOp::IncrementWrap};
            state.stencil.back = {.depth_fail = StencilOp::IncrementWrap, .pass = StencilOp::DecrementWrap};
        }
        state.depth = {.test = random.pick<Compare>(8), .write = random.chance(2)};
        state.viewport = wide_viewport(side, side);
        state.cull = random.pick<Cull>(3);
        state.front_face = random.pick<FrontFace>(2);
        Batch batch = random_batch(batch_size, {.width = side, .height = side, .snapped = random.chance(2)}, random);
        for (size_t t = 0; t < batch.triangles.size(); ++t) {
            const auto z =
                static_cast<float>(random.between(-3, 3)) * 0.25f; // one depth a triangle: gradients are zero
            for (size_t v = 0; v < 3; ++v) batch.positions[3 * t + v].z = z;
        }
        duel.clear(0.5f, random.bits() & 0xff);
        // Fans share no vertices here, so 3t + v above is triangle t.
        duel.draw(batch, state);
        covered += duel.counters().fragments_covered;
        const Picture a = duel.ours(), b = duel.witness();
        for (size_t k = 0; k < duel.pixels(); ++k) {
            wrong += a.stencil[k] != b.stencil[k];
            wrong_ids += a.ids[k] != b.ids[k];
            wrong_depth += a.depth[k] != b.depth[k];
        }
        pixels += side * side;
    }
    verdict.require(wrong == 0 && wrong_ids == 0 && wrong_depth == 0,
                    fmt::format("{} random states, {} pixels, {} covered fragments; pixels that differ: {} in stencil, "
                                "{} in id, {} in depth",
                                rounds, pixels, covered, wrong, wrong_ids, wrong_depth));
    return verdict.held();
}

} // namespace gnomon_conformance
