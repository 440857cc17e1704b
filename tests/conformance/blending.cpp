// Blending and colour masks: one colour a triangle, several triangles deep, under random factors and operations.

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "tests/conformance/triangles.h"

namespace gnomon_conformance {
namespace {

constexpr int side = 128;

Batch colored_batch(int count, bool wide, Random& random) {
    Batch batch;
    while (batch.triangles.size() < static_cast<size_t>(count))
        add_random(batch, random.chance(3) ? Shape::Huge : Shape::Large,
                   {.width = side, .height = side, .constant_depth = true}, random);
    for (size_t i = 0; i < batch.triangles.size(); ++i) {
        const auto channel = [&] { return static_cast<float>(wide ? random.real(-2, 3) : random.real(0, 1)); };
        batch.colors.emplace_back(channel(), channel(), channel(), channel());
    }
    return batch;
}

BlendState random_blend(Random& random) {
    BlendState blend;
    blend.enabled = true;
    for (BlendFactor* f :
         {&blend.source_color, &blend.destination_color, &blend.source_alpha, &blend.destination_alpha})
        *f = random.pick<BlendFactor>(12);
    blend.color = random.pick<BlendOp>(5), blend.alpha = random.pick<BlendOp>(5);
    blend.constant = vec4(dvec4(random.real(0, 1), random.real(0, 1), random.real(0, 1), random.real(0, 1)));
    return blend;
}

struct Difference {
    std::int64_t values = 0, beyond = 0, inexact = 0;
    double largest = 0; // in steps of the format
};

// Differences in steps of the format: 1/255, or the spacing of half or float numbers at the operands' magnitude.
void compare(const Duel& duel, Format format, double magnitude, Difference& d) {
    const Picture a = duel.ours(), b = duel.witness();
    const int mantissa = format == Format::RGBA16F ? 10 : 23;
    constexpr double least = std::numeric_limits<float>::min(); // zero has no magnitude
    for (size_t k = 0; k < duel.pixels(); ++k)
        for (glm::length_t c = 0; c < 4; ++c) {
            const auto ours = static_cast<double>(a.color[k][c]), theirs = static_cast<double>(b.color[k][c]);
            const double scale = std::max({std::abs(ours), std::abs(theirs), magnitude, least});
            const double step = format == Format::RGBA8 ? 1 / 255.0 : std::ldexp(1.0, std::ilogb(scale) - mantissa);
            const double steps = std::abs(ours - theirs) / step;
            ++d.values;
            d.inexact += steps > 0.01;
            d.beyond += !(steps <= 1.01); // catches NaN on one side
            d.largest = std::max(d.largest, steps);
        }
}

} // namespace

bool check_blending(const Options& options) {
    Verdict verdict("blending");
    Random random(options.seed + 7);
    for (const Format format : {Format::RGBA8, Format::RGBA16F, Format::RGBA32F}) {
        Duel duel({.width = side, .height = side, .color = format});
        const float unit = format == Format::RGBA8 ? 255.0f : 64.0f;
        const bool wide = format != Format::RGBA8;
        Difference one, deep, masks;
        for (int i = 0; i < options.repeat(80); ++i) {
            PipelineState state;
            state.viewport = wide_viewport(side, side);
            state.blend = random_blend(random);
            const vec4 background(dvec4(random.real(0, 1), random.real(0, 1), random.real(0, 1), random.real(0, 1)));
            // One blend onto the background everywhere; then layers, whose differences may add up but for the format.
            Batch single;
            single.add(vec4(-1, -1, 0, 1), vec4(1, -1, 0, 1), vec4(-1, 1, 0, 1));
            single.add(vec4(1, -1, 0, 1), vec4(1, 1, 0, 1), vec4(-1, 1, 0, 1));
            for (int k = 0; k < 2; ++k)
                single.colors.push_back(
                    wide ? vec4(dvec4(random.real(-2, 3), random.real(-2, 3), random.real(-2, 3), random.real(-2, 3)))
                         : vec4(dvec4(random.real(0, 1), random.real(0, 1), random.real(0, 1), random.real(0, 1))));
            duel.clear(1, 0, background);
            duel.draw(single, state);
            compare(duel, format, 6.0, one);
        }
        for (int i = 0; i < options.repeat(25); ++i) {
            PipelineState state;
            state.viewport = wide_viewport(side, side);
            for (std::uint8_t& mask : state.color_mask) mask = static_cast<std::uint8_t>(random.between(0, 15));
            duel.clear(1, 0, vec4(0.25f));
            // Values that every format holds exactly: how halves are rounded is the implementation's choice.
            Batch layers = colored_batch(64, wide, random);
            for (vec4& c : layers.colors) c = glm::round(c * 16.0f) / unit;
            duel.draw(layers, state);
            compare(duel, format, 0, masks);
            state.color_mask.fill(15);
            state.blend = BlendState::add();
            duel.clear();
            duel.draw(layers, state);
            compare(duel, format, 0, deep);
        }
        const char* name = info(format).name;
        verdict.require(one.beyond == 0,
                        fmt::format("{}, random factors and operations: {} values, {} not equal, {} by more than "
                                    "one step of the format; at most {:.2f} steps",
                                    name, one.values, one.inexact, one.beyond, one.largest));
        verdict.require(deep.inexact == 0,
                        fmt::format("{}, sums of up to 64 layers: {} values, {} not equal, at most {:.2f} steps", name,
                                    deep.values, deep.inexact, deep.largest));
        verdict.require(masks.inexact == 0,
                        fmt::format("{}, colour masks: {} values, {} not equal, at most {:.2f} steps", name,
                                    masks.values, masks.inexact, masks.largest));
    }
    return verdict.held();
}

} // namespace gnomon_conformance
