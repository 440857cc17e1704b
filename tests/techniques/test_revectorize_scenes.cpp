// Revectorization on shadow maps of scenes: the whole way from triangles to visibility.

#include <catch2/catch.hpp>

#include <cstring>

#include "core/parallel.h"
#include "tests/support.h"
#include "tests/techniques/mask_scene.h"
#include "tests/techniques/shading.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

constexpr const char* revectorized[] = {"smsr", "rbsm-cons", "rbsm-nonc", "rbsm-filt",
                                        "rpcf", "rpcf-opt",  "rpcf-hard", "edtsm"};

// Floor pixels whose answer is not `expected(texels)`, leaving out those too near to where it jumps or bends.
template <class Expected, class Skip>
int wrong_pixels(const MaskScene& mask, const Frame& frame, const Image<float>& values, const Expected& expected,
                 const Skip& skip) {
    int wrong = 0;
    for (size_t i = 0; i < values.size(); ++i) {
        const vec2 at = mask.texels(frame.receivers().data()[i].position);
        if (!skip(at)) wrong += std::abs(values.data()[i] - expected(at)) > 2e-3f;
    }
    return wrong;
}

bool near_half(float value) { return std::abs(2 * value - std::round(2 * value)) < 4e-3f; }

} // namespace

TEST_CASE("stairs that a scene casts become lines, under a directional light and a spot") {
    const LightType type = GENERATE(LightType::Directional, LightType::Spot);
    const int n = GENERATE(3, 7);
    INFO(light_type_name(type) << ", steps of " << n);
    const MaskScene mask =
        mask_scene(type, [n](int i) { return static_cast<int>(std::floor(static_cast<double>(i) / n)); });
    Frame frame = mask_frame(mask);
    const float slope = 1.0f / static_cast<float>(n);
    const auto skip = [&](vec2 p) { return near_half(p.y - slope * p.x) || near_half(p.x) || near_half(p.y); };
    const auto check = [&](const char* technique, const auto& expected) {
        INFO(technique);
        CHECK(wrong_pixels(mask, frame, shade(frame, mask.light, technique).values, expected, skip) == 0);
    };
    check("sm:size=64", [&](vec2 p) { return p.y < std::floor(std::floor(p.x) * slope + 1e-4f) ? 0.0f : 1.0f; });
    const auto outer = [&](vec2 p) { return p.y < slope * p.x ? 0.0f : 1.0f; };
    check("rbsm-cons:size=64", outer);
    check("rbsm-cons:size=64,continuation=share,stepping=float", outer);
    check("smsr:size=64", outer);
    const auto middle = [&](vec2 p) { return p.y < slope * p.x - 0.5f ? 0.0f : 1.0f; };
    check("rbsm-nonc:size=64", middle);
    check("rbsm-nonc:size=64,continuation=any,receiver-plane=on", middle);
    check("rbsm-filt:size=64", [&](vec2 p) { return std::clamp(1.0f + p.y - slope * p.x, 0.0f, 1.0f); });
}

TEST_CASE("the engine's variant fills the stairs of the dilated map, for a spot alone") {
    const MaskScene mask =
        mask_scene(LightType::Spot, [](int i) { return static_cast<int>(std::floor(static_cast<double>(i) / 4)); });
    Frame frame = mask_frame(mask);
    // Lit is whatever has a lit texel among the 2 × 2 around it: the mask, half a texel down and to the right.
    const auto skip = [](vec2 p) { return near_half(p.y - 0.25f * p.x + 0.125f) || near_half(p.x) || near_half(p.y); };
    const auto expected = [](vec2 p) { return p.y + 0.5f < 0.25f * (p.x - 0.5f) ? 0.0f : 1.0f; };
    const Image<float> unity = shade(frame, mask.light, "rbsm-cons:size=64,variant=unity").values;
    CHECK(wrong_pixels(mask, frame, unity, expected, skip) == 0);

    const MaskScene sunny = mask_scene(LightType::Directional, [](int) { return 0; });
    Frame other = mask_frame(sunny);
    CHECK_THROWS_WITH(shade(other, sunny.light, "rbsm-cons:variant=unity"),
                      "technique 'rbsm-cons': variant=unity needs a spot light, and 'light' is a directional light; "
                      "variant=glsl takes every light");
}

TEST_CASE("kernels of V** have no stairs along slopes of 1 over n, and kernels of tests do") {
    // Standard deviation of V along the edge, summed over offsets from it in steps of 1/16 texel. [Macedo 2018, 3.5]
    const MaskScene mask = mask_scene(LightType::Directional,
                                      [](int i) { return static_cast<int>(std::floor(static_cast<double>(i) / 4)); });
    Frame frame = mask_frame(mask);
    const auto jaggedness = [&](const char* technique) {
        const Image<float> values = shade(frame, mask.light, technique).values;
        std::vector<std::vector<double>> bins(16 * 6); // by offset from −3 to 3
        for (size_t i = 0; i < values.size(); ++i) {
            const vec2 at = mask.texels(frame.receivers().data()[i].position);
            const float offset = at.y - 0.25f * at.x + 0.5f;
            if (std::abs(offset) < 2.9f && std::abs(at.x) < 6)
                bins[static_cast<size_t>(16 * (offset + 3.0f))].push_back(static_cast<double>(values.data()[i]));
        }
        double sum = 0;
        for (const auto& bin : bins) {
            double mean = 0, square = 0;
            for (const double v : bin) mean += v, square += v * v;
            if (bin.size() < 32) continue;
            mean /= static_cast<double>(bin.size());
            sum += std::sqrt(std::max(0.0, square / static_cast<double>(bin.size()) - mean * mean)) / 16;
        }
        WARN("jaggedness of " << technique << " on a slope of 1/4: " << sum << " texel");
        return sum;
    };
    const double sm = jaggedness("sm:size=64"), pcf7 = jaggedness("pcf:size=64,kernel=7,radius=1");
    CHECK(sm == Approx(0.393).margin(0.06)); // π/8
    CHECK(pcf7 > 0.15);
    CHECK(jaggedness("pcf:size=64,kernel=15,radius=1") > 0.12);
    CHECK(jaggedness("pcf:size=64,kernel=7,radius=3.5") > 0.15);
    // A bin is 1/16 texel deep, in which a ramp of two texels or so varies by 1/32 at most, σ 0.009.
    CHECK(jaggedness("rbsm-nonc:size=64") < 0.04);
    CHECK(jaggedness("rbsm-filt:size=64") < 0.03);
    CHECK(jaggedness("rpcf:size=64") < 0.03);
    CHECK(jaggedness("edtsm:size=64,penumbra=0.25,kernel=0") < 0.1);
}

TEST_CASE("rpcf is pcf where there is no silhouette") {
    const Scene scene = load_scene(GENERATE(as<std::string>(), "builtin:default", "builtin:fence"));
    Frame frame(scene, scene.cameras[0], 320, 180);
    const Light& light = scene.lights[0];
    const Visibility pcf = shade(frame, light, "pcf:size=512,kernel=7,radius=1");
    for (const char* technique : {"rpcf:size=512", "rpcf-opt:size=512", "rpcf-hard:size=512"}) {
        INFO(technique);
        const Visibility filtered = shade(frame, light, technique);
        const Image<float>& silhouette = debug_image(filtered, "discontinuities");
        int differ = 0, without = 0, on_it = 0;
        for (size_t i = 0; i < silhouette.size(); ++i) {
            const bool equal = filtered.values.data()[i] == pcf.values.data()[i];
            if (silhouette.data()[i] == 0)
                ++without, differ += !equal;
            else
                on_it += !equal;
        }
        CHECK(without > 20000);
        CHECK(differ == 0);
        CHECK(on_it > 200);
    }
}

TEST_CASE("rpcf-opt walks less than rpcf, and differs where runs share a direction") {
    const Scene scene = load_scene("builtin:default");
    Frame frame(scene, scene.cameras[0], 640, 360);
    const Visibility naive = shade(frame, scene.lights[0], "rpcf:size=1024");
    const Visibility reused = shade(frame, scene.lights[0], "rpcf-opt:size=1024");
    double largest = 0, sum = 0, walks = 0, fewer = 0;
    int differ = 0, silhouette = 0;
    for (size_t i = 0; i < naive.values.size(); ++i) {
        const double d =
            std::abs(static_cast<double>(naive.values.data()[i]) - static_cast<double>(reused.values.data()[i]));
        largest = std::max(largest, d), sum += d, differ += d > 1e-5;
        silhouette += debug_image(naive, "discontinuities").data()[i] != 0;
        walks += static_cast<double>(debug_image(naive, "traversals").data()[i]);
        fewer += static_cast<double>(debug_image(reused, "traversals").data()[i]);
    }
    WARN("rpcf-opt: " << fewer / walks << " of rpcf's traversals; " << differ << " of " << silhouette
                      << " silhouette pixels differ, mean " << sum / silhouette << ", at most " << largest);
    CHECK(fewer < 0.4 * walks);
    CHECK(sum / silhouette < 0.005);
    CHECK(differ > 0); // it is no mere speed-up
}

TEST_CASE("the conservative shadow covers that of sm and leaves alone what has no silhouette") {
    const Scene scene = load_scene(GENERATE(as<std::string>(), "builtin:default", "builtin:colonnade"));
    Frame frame(scene, scene.cameras[0], 640, 360);
    const Light& light = scene.lights[0];
    const Image<float> sm = shade(frame, light, "sm:size=512").values;
    for (const char* technique : {"rbsm-cons:size=512", "smsr:size=512"}) {
        INFO(technique);
        const Visibility cons = shade(frame, light, technique);
        const Image<float>& silhouette = debug_image(cons, "discontinuities");
        int lighter = 0, elsewhere = 0, darker = 0;
        for (size_t i = 0; i < sm.size(); ++i) {
            const float difference = cons.values.data()[i] - sm.data()[i];
            lighter += difference > 0, darker += difference < 0;
            elsewhere += difference != 0 && silhouette.data()[i] == 0;
        }
        CHECK(lighter == 0);
        CHECK(elsewhere == 0);
        CHECK(darker > 500);
    }
}

TEST_CASE("revectorized shadows are nearer to ray-traced ones than sm's") {
    const bool dragon = GENERATE(false, true);
    const std::string path = dragon ? shared_path("scenes/dragon/dragon.glb") : "builtin:default";
    if (path.empty()) return;
    const Scene scene = load_scene(path);
    Frame frame(scene, scene.cameras[0], 1280, 720);
    const Light& light = scene.lights[0];
    const Image<float> rays = shade(frame, light, "raytraced").values;
    const auto error = [&](const std::string& technique) {
        const double value = facing_rmse(frame, light, shade(frame, light, technique + ":size=1024").values, rays);
        WARN(scene.name << ": " << technique << " 1024 has RMSE " << value);
        return value;
    };
    const double sm = error("sm");
    CHECK(error("rbsm-nonc") < sm);
    CHECK(error("rbsm-filt") < sm);
    error("rbsm-cons"); // which moves every edge by half a texel: no bound
    error("smsr");
}

TEST_CASE("runs cross the faces of a cube map") {
    const Scene scene = box_over_floor();
    Frame frame(scene, scene.cameras[0], 320, 240);
    const Light light = point_light({0.9f, 2.4f, 0.6f}); // its faces meet on the floor across the shadow's edges
    const Image<float> rays = shade(frame, light, "raytraced").values;
    const double sm = facing_rmse(frame, light, shade(frame, light, "sm:size=256,projection=cube").values, rays);
    for (const char* technique : {"rbsm-nonc", "rbsm-filt"}) {
        const std::string specification = std::string(technique) + ":size=256,projection=cube";
        const double error = facing_rmse(frame, light, shade(frame, light, specification).values, rays);
        WARN(specification << " has RMSE " << error << ", sm " << sm);
        CHECK(error < sm);
    }
    // And no seam: what has no caster near it is lit on every face.
    for (const char* technique : revectorized) {
        INFO(technique);
        const Image<float> values = shade(frame, light, std::string(technique) + ":size=256,projection=cube").values;
        float least = 1.0f;
        for (size_t i = 0; i < values.size(); ++i) {
            const Receiver& receiver = frame.receivers().data()[i];
            if (receiver.valid() && receiver.triangle < 2 && receiver.position.x > 1.6f)
                least = std::min(least, values.data()[i]);
        }
        CHECK(least >= 0.999f);
    }
}

TEST_CASE("what lies outside the map is as the border says, runs included") {
    const MaskScene mask = mask_scene(LightType::Spot, [](int) { return -64; });
    Camera camera = look_at({0.0f, 9.0f, 0.0f}, {0.0f, 0.0f, 0.0f}, 0.8f); // sees past the cone
    camera.near_plane = 1.0f, camera.far_plane = 10.0f;
    Frame frame(mask.scene, camera, 160, 160);
    for (const char* technique : revectorized) {
        if (std::strcmp(technique, "edtsm") == 0) continue; // its mean reaches over the border
        INFO(technique);
        for (const bool lit : {true, false}) {
            const std::string specification = std::string(technique) + (lit ? ":size=64" : ":size=64,border=shadow");
            const Image<float> values = shade(frame, mask.light, specification).values;
            int outside = 0, wrong = 0;
            for (size_t i = 0; i < values.size(); ++i) {
                const vec2 at = glm::abs(mask.texels(frame.receivers().data()[i].position));
                const float reach = std::max(at.x, at.y);
                if (std::abs(reach - mask_side / 2) < 1.5f) continue;
                outside += reach > mask_side / 2;
                wrong += values.data()[i] != (lit || reach < mask_side / 2 ? 1.0f : 0.0f);
            }
            CHECK(outside > 1000);
            CHECK(wrong == 0);
        }
    }
}

TEST_CASE("revectorization gives the same bits for any number of threads") {
    const Scene scene = load_scene("builtin:default");
    for (const char* technique : revectorized) {
        INFO(technique);
        Image<float> one, many;
        const auto run = [&](int threads, Image<float>& values) {
            with_threads(threads, [&] {
                Frame frame(scene, scene.cameras[0], 320, 180);
                values = shade(frame, scene.lights[0], std::string(technique) + ":size=256").values;
            });
        };
        run(1, one);
        run(7, many);
        CHECK(std::memcmp(one.data(), many.data(), one.size() * sizeof(float)) == 0);
    }
}

TEST_CASE("the published settings draw a shadow in the units of the author's scenes") {
    // His fence, roughly: a plane of 120 × 80 units, the light at (10, 130, 100).
    Scene scene = box_over_floor();
    for (vec3& p : scene.positions) p *= 12.0f;
    scene.bounds = {};
    for (const vec3& p : scene.positions) scene.bounds.extend(p);
    Camera camera = look_at({0, 84, 72}, {0, 0, 0}, 0.8f);
    camera.near_plane = 1.0f, camera.far_plane = 1000.0f;
    Frame frame(scene, camera, 320, 240);
    const Light light = point_light({10, 130, 100});
    const Image<float> rays = shade(frame, light, "raytraced").values;
    for (const char* technique : revectorized) {
        const double error =
            facing_rmse(frame, light, shade(frame, light, std::string(technique) + ":preset=published").values, rays);
        INFO(technique << " " << error);
        CHECK(error < 0.1);
    }
}
