#include "tests/conformance/triangles.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace gnomon_conformance {
namespace {

// Window position in pixels and depth in (−1, 1) to clip space. Powers of two for sizes keep snapped positions exact.
vec4 to_clip(dvec2 window, double depth, const TriangleOptions& options, Random& random) {
    const dvec2 size(options.width, options.height);
    window = glm::clamp(window, -1.49 * size, 2.49 * size);
    if (options.snapped) window = glm::round(window * 256.0) / 256.0;
    const Rectangle viewport = wide_viewport(options.width, options.height);
    const dvec2 half(0.5 * viewport.width, 0.5 * viewport.height);
    const dvec2 ndc = (window - dvec2(viewport.x, viewport.y)) / half - 1.0;
    const double w = options.divided ? std::exp2(random.real(-3, 5)) : 1.0;
    return vec4(dvec4(ndc.x * w, ndc.y * w, depth * w, w));
}

} // namespace

int add_random(Batch& batch, Shape shape, const TriangleOptions& options, Random& random) {
    const double w = options.width, h = options.height;
    const dvec2 at(random.real(-0.1 * w, 1.1 * w), random.real(-0.1 * h, 1.1 * h));
    const double constant = random.real(-0.9, 0.9);
    const auto depth = [&] { return options.constant_depth ? constant : random.real(-0.99, 0.99); };
    const auto around = [&](double x, double y) { return at + dvec2(random.real(-x, x), random.real(-y, y)); };
    std::array<dvec2, 3> p;
    switch (shape) {
    case Shape::Small:
        for (dvec2& v : p) v = around(5, 5);
        break;
    case Shape::Tiny:
        for (dvec2& v : p) v = around(0.7, 0.7);
        break;
    case Shape::Sliver: {
        const dvec2 along = around(60, 60) - at;
        p = {at, at + along,
             at + along * random.real(0, 1) + dvec2(random.real(-0.05, 0.05), random.real(-0.05, 0.05))};
        break;
    }
    case Shape::OnGrid: // vertices and edges through pixel centres and corners
        for (dvec2& v : p) v = glm::floor(around(8, 8)) + dvec2(random.chance(2) ? 0.5 : 0.0);
        break;
    case Shape::Fan: { // shared edges around a shared vertex, in both windings
        constexpr int sides = 8;
        std::array<vec4, sides + 1> ring;
        for (int i = 0; i < sides; ++i) {
            const double angle = 2 * pi * (i + random.real(0, 0.9)) / sides, radius = random.real(1, 9);
            ring[static_cast<size_t>(i)] =
                to_clip(at + radius * dvec2(std::cos(angle), std::sin(angle)), depth(), options, random);
        }
        ring[sides] = ring[0];
        const vec4 middle = to_clip(at, depth(), options, random);
        for (size_t i = 0; i < sides; ++i)
            i % 2 ? batch.add(middle, ring[i], ring[i + 1]) : batch.add(ring[i + 1], ring[i], middle);
        return sides;
    }
    case Shape::Border:
        for (dvec2& v : p) v = dvec2(random.chance(2) ? w : 0.0, random.real(0, h)) + dvec2(random.real(-9, 9), 0);
        if (random.chance(2))
            for (dvec2& v : p) v = dvec2(v.y / h * w, v.x / w * h);
        p[1] = p[0] + dvec2(random.real(-9, 9), random.real(-9, 9)),
        p[2] = p[0] + dvec2(random.real(-9, 9), random.real(-9, 9));
        break;
    case Shape::Degenerate: // repeated or collinear vertices, or an area of a few sub-pixels
        p[0] = around(5, 5), p[1] = around(5, 5);
        p[2] = random.chance(3) ? p[random.chance(2)] : p[0] + (p[1] - p[0]) * (random.between(-4, 4) / 4.0);
        if (random.chance(4)) p[2] += dvec2(random.between(-1, 1), random.between(-1, 1)) / 256.0;
        break;
    case Shape::Large:
        for (dvec2& v : p) v = around(90, 90);
        break;
    case Shape::Huge:
        for (dvec2& v : p) v = dvec2(random.real(-0.49 * w, 1.49 * w), random.real(-0.49 * h, 1.49 * h));
        break;
    }
    std::array<vec4, 3> clip;
    for (size_t i = 0; i < 3; ++i) clip[i] = to_clip(p[i], depth(), options, random);
    batch.add(clip[0], clip[1], clip[2]);
    return 1;
}

Batch random_batch(int count, const TriangleOptions& options, Random& random) {
    Batch batch;
    int made = 0;
    for (int i = 0; i < count / 1024; ++i) made += add_random(batch, Shape::Huge, options, random);
    for (int i = 0; i < count / 128; ++i) made += add_random(batch, Shape::Large, options, random);
    constexpr Shape mix[] = {Shape::Small,  Shape::Small, Shape::Tiny,   Shape::Sliver,
                             Shape::OnGrid, Shape::Fan,   Shape::Border, Shape::Degenerate};
    while (made < count) made += add_random(batch, mix[random.between(0, 7)], options, random);
    return batch;
}

} // namespace gnomon_conformance
