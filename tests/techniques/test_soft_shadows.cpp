#include <catch2/catch.hpp>

#include <cmath>

#include "tests/support.h"
#include "tests/techniques/shading.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

// The half-plane penumbra of a 2×2 light at height 4 over an edge at height 2: linear in x from −1 to 1 on the floor
// (analytic/reference_values.json). Rows of floor receivers near z = 0, by x.
struct Profile {
    double largest_error = 0, mean_error = 0;
    int count = 0;
};

Profile penumbra_profile(const Frame& frame, const Image<float>& visibility, float low_x, float high_x) {
    Profile profile;
    for (int y = 0; y < frame.height(); ++y)
        for (int x = 0; x < frame.width(); ++x) {
            const Receiver& receiver = frame.receivers()(x, y);
            if (!receiver.valid() || std::abs(receiver.position.y) > 1e-4f || std::abs(receiver.position.z) > 0.5f)
                continue;
            if (receiver.position.x < low_x || receiver.position.x > high_x) continue;
            const float expected = std::clamp(0.5f + 0.5f * receiver.position.x, 0.0f, 1.0f);
            const double error = std::abs(static_cast<double>(visibility(x, y) - expected));
            profile.largest_error = std::max(profile.largest_error, error);
            profile.mean_error += error;
            ++profile.count;
        }
    profile.mean_error /= std::max(1, profile.count);
    return profile;
}

} // namespace

TEST_CASE("truth and soft shadows meet the half-plane's linear penumbra") {
    const Scene scene = load_scene("builtin:half-plane");
    Frame frame(scene, scene.cameras[0], 640, 360);
    const Light& light = scene.lights[0];
    const Profile truth = penumbra_profile(frame, shade(frame, light, "truth:samples=1024").values, -1.5f, 1.5f);
    CHECK(truth.count > 300);
    // A (0,2)-net of 2¹⁰ points splits the square along a straight edge with an error of at most a few 2⁻⁵ cells'
    // worth.
    CHECK(truth.largest_error < 0.02);
    const Profile grid =
        penumbra_profile(frame, shade(frame, light, "truth:samples=1024,pattern=grid").values, -1.5f, 1.5f);
    CHECK(grid.largest_error <= 1.0 / 64 + 1e-3); // half a column of the 32×32 grid

    // PCSS knows the exact penumbra here: parallel light, blocker and receiver.
    const Profile pcss =
        penumbra_profile(frame, shade(frame, light, "pcss:size=2048,kernel=31,search=21").values, -0.6f, 0.9f);
    CHECK(pcss.mean_error < 0.04);
    const Profile hard = penumbra_profile(frame, shade(frame, light, "sm").values, -0.6f, 0.9f);
    CHECK(hard.mean_error > 3 * pcss.mean_error);
}

TEST_CASE("a planar receiver under filtered maps has no acne") {
    // The floor under an unblocked part of the light: every filter must say exactly or nearly lit.
    const Scene scene = box_over_floor();
    Frame frame(scene, scene.cameras[0], 320, 240);
    const Light light = point_light({2.5f, 3, 1});
    for (const char* technique : {"pcf", "pcf:kernel=31", "pcss:light-size=0.5", "vsm", "vsm:blur=box"}) {
        INFO(technique);
        const Image<float> visibility = shade(frame, light, technique).values;
        float least = 1.0f;
        int count = 0;
        for (int y = 0; y < frame.height(); ++y)
            for (int x = 0; x < frame.width(); ++x) {
                const Receiver& receiver = frame.receivers()(x, y);
                if (!receiver.valid() || receiver.triangle >= 2 || receiver.position.x < 1.5f) continue;
                least = std::min(least, visibility(x, y));
                ++count;
            }
        CHECK(count > 1000);
        CHECK(least >= 0.999f);
    }
}

TEST_CASE("filters cross the faces of a cube map without a seam") {
    // A light close to the floor sees it on five faces. Lit everywhere but under the box.
    const Scene scene = box_over_floor();
    Frame frame(scene, scene.cameras[0], 320, 240);
    const Light light = point_light({2.0f, 2.0f, 2.0f});
    for (const char* technique : {"pcf:projection=cube", "pcss:projection=cube,light-size=1", "vsm:projection=cube"}) {
        INFO(technique);
        const Image<float> visibility = shade(frame, light, technique).values;
        float least = 1.0f;
        for (int y = 0; y < frame.height(); ++y)
            for (int x = 0; x < frame.width(); ++x) {
                const Receiver& receiver = frame.receivers()(x, y);
                if (!receiver.valid() || receiver.triangle >= 2) continue;
                if (receiver.position.x > 1.2f && receiver.position.z > 1.2f) least = std::min(least, visibility(x, y));
            }
        CHECK(least >= 0.999f);
    }
}

TEST_CASE("variance shadow maps follow Chebyshev's inequality between two depths") {
    // Under the box's edge the blurred map holds a mixture of the box's top and the floor: V must fall monotonically
    // into the shadow and stay within [0, 1].
    const Scene scene = box_over_floor();
    Frame frame(scene, scene.cameras[0], 320, 240);
    const Light light = point_light({0, 4, 0});
    const Image<float> visibility = shade(frame, light, "vsm:kernel=15").values;
    float umbra = 1.0f, lit = 0.0f;
    for (int y = 0; y < frame.height(); ++y)
        for (int x = 0; x < frame.width(); ++x) {
            const Receiver& receiver = frame.receivers()(x, y);
            if (!receiver.valid() || receiver.triangle >= 2) continue;
            REQUIRE(visibility(x, y) >= 0.0f);
            REQUIRE(visibility(x, y) <= 1.0f);
            const float edge = std::max(std::abs(receiver.position.x), std::abs(receiver.position.z));
            if (edge < 0.7f) umbra = std::min(umbra, visibility(x, y));
            if (edge > 1.0f) lit = std::max(lit, visibility(x, y));
        }
    CHECK(umbra < 0.01f);
    CHECK(lit == 1.0f);
}
