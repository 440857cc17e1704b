#include <catch2/catch.hpp>

#include <cmath>

#include "tests/support.h"
#include "tests/techniques/shading.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

// Floor pixels whose answer differs from the closed form, leaving out those whose point lies within `margin` metres of
// the shadow's edge: under the light (0, 4, 0) the box darkens |x|, |z| ≤ 0.8, its top face enlarged by 4/(4 − 1.5).
int wrong_floor_pixels(const Frame& frame, const Image<float>& visibility, float margin) {
    int wrong = 0;
    for (int y = 0; y < frame.height(); ++y)
        for (int x = 0; x < frame.width(); ++x) {
            const Receiver& receiver = frame.receivers()(x, y);
            if (!receiver.valid() || receiver.triangle >= 2) continue;
            const float distance = std::max(std::abs(receiver.position.x), std::abs(receiver.position.z)) - 0.8f;
            if (std::abs(distance) < margin) continue;
            wrong += visibility(x, y) != (distance > 0 ? 1.0f : 0.0f);
        }
    return wrong;
}

} // namespace

TEST_CASE("hard techniques draw the shadow of a box where geometry puts it") {
    const Scene scene = box_over_floor();
    Frame frame(scene, scene.cameras[0], 320, 240);
    const Light light = point_light({0, 4, 0});
    CHECK(wrong_floor_pixels(frame, shade(frame, light, "raytraced").values, 1e-5f) == 0);
    CHECK(wrong_floor_pixels(frame, shade(frame, light, "truth:samples=16").values, 1e-5f) == 0);
    // A volume's edge is snapped to 1/256 pixel; a pixel of this view spans less than 4 cm.
    for (const char* volumes : {"sv-zfail", "sv-zfail:stencil=s8", "sv-zpass", "sv-zpass:stencil=s8"}) {
        INFO(volumes);
        CHECK(wrong_floor_pixels(frame, shade(frame, light, volumes).values, 0.04f / 256) == 0);
    }
    // A texel of the map spans at most 2·5·4/(4 − 1.5)/1024 m here, and its offset moves the edge by less than another.
    for (const char* map :
         {"sm", "sm:format=d24", "sm:normal-offset=1.5,slope-bias=1", "sm:projection=cube", "pcf:kernel=1"}) {
        INFO(map);
        CHECK(wrong_floor_pixels(frame, shade(frame, light, map).values, 0.04f) == 0);
    }
}

TEST_CASE("spot and directional lights cast the same shadow from the same direction") {
    const Scene scene = box_over_floor();
    Frame frame(scene, scene.cameras[0], 320, 240);
    Light spot = point_light({0, 4, 0});
    spot.type = LightType::Spot;
    spot.outer_cone = 0.9f;
    CHECK(wrong_floor_pixels(frame, shade(frame, spot, "sm").values, 0.05f) == 0);
    CHECK(wrong_floor_pixels(frame, shade(frame, spot, "sv-zfail").values, 1e-3f) == 0);

    Light sun;
    sun.type = LightType::Directional;
    sun.direction = glm::normalize(vec3(1, -2, 0.5f));
    const Image<float> rays = shade(frame, sun, "raytraced").values;
    for (const char* technique : {"sm", "sv-zfail", "sv-zpass", "pcf:kernel=1", "vsm:kernel=1"}) {
        INFO(technique);
        CHECK(facing_rmse(frame, sun, shade(frame, sun, technique).values, rays) < 0.08);
    }
    CHECK(facing_rmse(frame, sun, shade(frame, sun, "sv-zfail").values, rays) < 0.02);
}

TEST_CASE("depth-fail is right with the eye inside a shadow volume, depth-pass with the right start value too") {
    const Scene scene = box_over_floor();
    Camera camera = look_at({0.1f, 0.3f, 0.05f}, {2.0f, 0.0f, 0.3f}, 1.0f); // under the box
    camera.near_plane = 0.01f;
    camera.far_plane = 30.0f;
    Frame frame(scene, camera, 160, 120);
    const Light light = point_light({0, 4, 0});
    CHECK(wrong_floor_pixels(frame, shade(frame, light, "sv-zfail").values, 2e-3f) == 0);
    CHECK(wrong_floor_pixels(frame, shade(frame, light, "sv-zpass").values, 2e-3f) == 0);
    CHECK(wrong_floor_pixels(frame, shade(frame, light, "sv-zpass:eye-count=false").values, 2e-3f) > 1000);
}

TEST_CASE("an unsupported light is an error that names what is supported") {
    const Scene scene = box_over_floor();
    Frame frame(scene, scene.cameras[0], 32, 24);
    Light sun;
    sun.name = "sun";
    sun.type = LightType::Directional;
    CHECK_THROWS_WITH(shade(frame, sun, "pcss"), "technique 'pcss' does not support the directional light 'sun'; it "
                                                 "supports point, spot, rectangle, disk, sphere");
    CHECK_THROWS_AS(shade(frame, sun, "sm:projection=cube"), UsageError);
    CHECK_THROWS_WITH(shade(frame, sun, "psm"), Catch::Contains("did you mean"));
}

TEST_CASE("stencil volumes agree with ray tracing on the closed bunny") {
    const std::string path = shared_path("scenes/bunny_closed/bunny_closed.glb");
    if (path.empty()) return;
    const Scene scene = load_scene(path);
    Frame frame(scene, scene.cameras[0], 1280, 720);
    const Light& light = scene.lights[0];
    const Image<float> volumes = shade(frame, light, "sv-zfail").values;
    const Image<float> rays = shade(frame, light, "raytraced").values;
    std::int64_t receivers = 0, differ = 0, unexplained = 0;
    const auto lit = [&](int x, int y) { return rays(x, y); };
    const auto facing = [&](int x, int y) {
        const Receiver& receiver = frame.receivers()(x, y);
        return receiver.valid() && faces_light(receiver, light);
    };
    for (int y = 0; y < 720; ++y)
        for (int x = 0; x < 1280; ++x) {
            if (!frame.receivers()(x, y).valid()) continue;
            ++receivers;
            if (volumes(x, y) == rays(x, y)) continue;
            ++differ;
            unexplained += !changes_nearby(x, y, 1280, 720, 2, lit) && !changes_nearby(x, y, 1280, 720, 2, facing);
        }
    const double agreement = 1.0 - static_cast<double>(differ) / static_cast<double>(receivers);
    WARN("sv-zfail agrees with raytraced on " << 100 * agreement << " % of " << receivers << " receivers; " << differ
                                              << " differ, " << unexplained << " away from boundary and terminator");
    CHECK(receivers > 100000);
    CHECK(agreement >= 0.999);
    CHECK(unexplained == 0);
}

TEST_CASE("a larger shadow map is a better one") {
    const bool armadillo = GENERATE(false, true);
    const std::string path = armadillo ? shared_path("scenes/armadillo/armadillo.glb") : "builtin:fence";
    if (path.empty()) return;
    const Scene scene = load_scene(path);
    Frame frame(scene, scene.cameras[0], 1280, 720);
    const Light& light = scene.lights[0];
    const Image<float> rays = shade(frame, light, "raytraced").values;
    double last = 1.0;
    for (const int size : {512, 1024, 2048, 4096}) {
        const double error =
            facing_rmse(frame, light, shade(frame, light, "sm:size=" + std::to_string(size)).values, rays);
        WARN(scene.name << ": sm " << size << " has RMSE " << error);
        CHECK(error < last);
        last = error;
    }
}
