// How fast the error falls with the number of samples, and whether the error bar says how large it is.

#include <catch2/catch.hpp>

#include <cmath>

#include "core/random.h"
#include "raytrace/truth.h"
#include "tests/raytrace/closed_forms.h"
#include "tests/raytrace/shapes.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

// Pixels of the penumbra of a slanted half-plane before a square light, with their exact visible fractions.
struct Penumbra {
    Scene scene;
    Receivers receivers;
    std::vector<double> exact;
    Light light = light_at(LightType::Rectangle, {0, 4, 0}, {2, 2});
};

Penumbra penumbra(int count) {
    Penumbra penumbra;
    const dvec2 normal(std::cos(0.4), std::sin(0.4));
    const auto corner = [&](double along, double across) {
        return vec3(dvec3(normal.x * along - normal.y * across, 2, normal.y * along + normal.x * across));
    };
    add_floor(penumbra.scene, -2, 2, -2, 2, 0);
    add_polygon(penumbra.scene, {corner(0, -16), corner(0, 16), corner(16, 16), corner(16, -16)});
    const FlatOccluder occluder{2, {{normal, 0}}, 0};
    std::vector<vec3> points;
    for (std::uint32_t i = 0; points.size() < static_cast<size_t>(count); ++i) {
        const vec3 p(2 * to_unit(hash(i, 1)) - 1, 0, 2 * to_unit(hash(i, 2)) - 1);
        const double fraction = visible_fraction(flat(penumbra.light, dvec3(p)), &occluder, dvec3(p));
        if (fraction < 0.05 || fraction > 0.95) continue;
        points.push_back(p);
        penumbra.exact.push_back(fraction);
    }
    penumbra.receivers = receivers_on_floor(points, 0);
    for (int i = 0; i < count; ++i)
        penumbra.receivers(i, 0).triangle = points[size_t(i)].x > points[size_t(i)].z ? 1 : 0;
    return penumbra;
}

struct Errors {
    double root_mean_square = 0;
    double claimed = 0; // root mean square of the error bars
};

Errors errors_of(const Penumbra& penumbra, const EmbreeScene& rays, Pattern pattern, int samples) {
    TruthSettings settings;
    settings.pattern = pattern;
    settings.samples = samples;
    const TruthAnswer answer = area_truth(rays, penumbra.receivers, penumbra.light, settings);
    double squares = 0, claimed = 0;
    for (size_t i = 0; i < penumbra.exact.size(); ++i) {
        const double error = double(answer.visibility.values()[i]) - penumbra.exact[i];
        squares += error * error;
        claimed += double(answer.error.values()[i]) * double(answer.error.values()[i]);
    }
    const auto n = static_cast<double>(penumbra.exact.size());
    return {std::sqrt(squares / n), std::sqrt(claimed / n)};
}

// Least-squares slope of log error over log samples.
double slope(const std::vector<std::pair<int, double>>& points) {
    double x = 0, y = 0, xx = 0, xy = 0;
    for (const auto& [samples, error] : points) {
        const double u = std::log(samples), v = std::log(error);
        x += u, y += v, xx += u * u, xy += u * v;
    }
    const auto n = static_cast<double>(points.size());
    return (n * xy - x * y) / (n * xx - x * x);
}

} // namespace

// One straight edge through cells of area 1/N: the variance is that of √N cells, so the error falls as N^(−3/4); of
// independent samples as N^(−1/2).
TEST_CASE("stratified errors fall faster than those of independent samples", "[raytrace][truth]") {
    const Penumbra scene = penumbra(400);
    const EmbreeScene rays(scene.scene);
    for (const Pattern pattern :
         {Pattern::Sobol, Pattern::Stratified, Pattern::Random, Pattern::Halton, Pattern::Poisson}) {
        std::vector<std::pair<int, double>> points;
        for (const int samples : {16, 64, 256, 1024, 4096})
            points.emplace_back(samples, errors_of(scene, rays, pattern, samples).root_mean_square);
        const double found = slope(points);
        INFO("pattern " << static_cast<int>(pattern) << ": slope " << found << ", error at 1024 " << points[3].second);
        if (pattern == Pattern::Sobol || pattern == Pattern::Stratified) CHECK(found < -0.7);
        if (pattern == Pattern::Random) CHECK(std::abs(found + 0.5) < 0.05);
        if (pattern == Pattern::Halton) CHECK(found < -0.6);
        if (pattern == Pattern::Poisson) CHECK(found < -0.5);
    }
}

// Neither hopeful nor useless: on the whole the bars are no smaller than the errors, and no more than three times as
// large.
TEST_CASE("error bars are as large as the errors", "[raytrace][truth]") {
    const Penumbra scene = penumbra(1000);
    const EmbreeScene rays(scene.scene);
    for (const Pattern pattern :
         {Pattern::Sobol, Pattern::Stratified, Pattern::Random, Pattern::Halton, Pattern::Poisson})
        for (const int samples : {64, 100, 256, 1024}) {
            const Errors errors = errors_of(scene, rays, pattern, samples);
            INFO("pattern " << static_cast<int>(pattern) << ", " << samples << " samples: error "
                            << errors.root_mean_square << ", bar " << errors.claimed);
            // 1000 pixels know the root mean square to 1/√2000 = 2.2 %.
            CHECK(errors.claimed > 0.93 * errors.root_mean_square);
            CHECK(errors.claimed < 3 * errors.root_mean_square);
        }
}

TEST_CASE("a target error stops pixels when it is met", "[raytrace][truth]") {
    const Penumbra scene = penumbra(500);
    const EmbreeScene rays(scene.scene);
    TruthSettings settings;
    settings.samples = 16384;
    for (const float target : {0.02f, 0.005f}) {
        settings.target_error = target;
        const TruthAnswer answer = area_truth(rays, scene.receivers, scene.light, settings);
        double squares = 0, samples = 0;
        for (size_t i = 0; i < scene.exact.size(); ++i) {
            CHECK((answer.error.values()[i] <= target || answer.samples.values()[i] == 16384.0f));
            const double error = double(answer.visibility.values()[i]) - scene.exact[i];
            squares += error * error;
            samples += double(answer.samples.values()[i]);
        }
        INFO("target " << target << ", mean samples " << samples / 500);
        CHECK(std::sqrt(squares / 500) <= double(target));
        CHECK(samples / 500 < 4096);
        // What is traced is what is counted.
        CHECK(answer.rays <= static_cast<std::int64_t>(samples));
    }
    settings.pattern = Pattern::Grid;
    CHECK_THROWS_AS(area_truth(rays, scene.receivers, scene.light, settings), UsageError);
}
