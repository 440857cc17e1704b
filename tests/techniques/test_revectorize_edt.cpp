// Penumbrae from distance transforms. [Macedo 2018, 4.2, 5.2 of the specification, A23, A24, A28, A29]

#include <catch2/catch.hpp>

#include "core/primitives.h"
#include "techniques/revectorize/edt_penumbra.h"
#include "tests/techniques/mask_scene.h"
#include "tests/techniques/shading.h"

using namespace gnomon;
using namespace gnomon_tests;

TEST_CASE("depth scales, z_screen and penumbra intensities are their formulas") {
    CHECK(scaled_depth(DepthScale::PseudoLinear, 64.0f, 1.0f, 1000.0f) == Approx(128.0 / 1064));
    CHECK(scaled_depth(DepthScale::Linear, 64.0f, 1.0f, 1000.0f) == Approx(63.0 / 999));
    CHECK(z_screen(glm::radians(45.0), false) == Approx(1.207107).epsilon(1e-6));
    CHECK(15 * z_screen(glm::radians(45.0), false) * 50 / 60 == Approx(15.0888).epsilon(1e-5));

    CHECK(penumbra_intensity(0.0f, 0.0f, 2.0f) == 0.5f); // on the silhouette, from either side
    CHECK(penumbra_intensity(1.0f, 0.0f, 2.0f) == 0.5f);
    CHECK(penumbra_intensity(0.0f, 1.0f, 2.0f) == 0.0f); // continuous at its border
    CHECK(penumbra_intensity(1.0f, 1.0f, 2.0f) == 1.0f);
    CHECK(penumbra_intensity(1.0f, 0.5f, 2.0f) == 0.75f);
    CHECK(penumbra_intensity(0.0f, 0.5f, 2.0f) == 0.25f);
    CHECK(penumbra_intensity(0.0f, 1.01f, 2.0f) == 0.0f);
    CHECK(penumbra_intensity(1.0f, infinity, 2.0f) == 1.0f); // no seed
    CHECK(penumbra_intensity(0.0f, 0.0f, 0.0f) == 0.0f);     // no width
}

TEST_CASE("a straight edge becomes a ramp between two rows of one half") {
    const MaskScene mask = mask_scene(LightType::Directional, [](int) { return 0; });
    Frame frame = mask_frame(mask);
    const float pixel = static_cast<float>(mask.texel_width()) / 16.0f, width = 20 * pixel;
    const Visibility edge = shade(frame, mask.light, "edtsm:size=64,kernel=0,penumbra=" + std::to_string(width));
    const Image<float>&hard = debug_image(edge, "hard"), &seeds = debug_image(edge, "seeds");
    int first_lit = 0; // row
    while (hard(128, first_lit) == 0) ++first_lit;
    REQUIRE(first_lit > 100);
    REQUIRE(first_lit < 156);
    for (int y = 0; y < mask_pixels; ++y) {
        const int rows = y >= first_lit ? y - first_lit : first_lit - 1 - y; // from the seed on this side
        CHECK(seeds(128, y) == (rows == 0 ? 1.0f : 0.0f));
        const float ramp = 0.5f - static_cast<float>(rows) * pixel / width;
        const float expected = rows <= 10 ? ramp : 0.0f;
        CHECK(edge.values(128, y) == Approx(y >= first_lit ? 1 - expected : expected).margin(1e-4));
    }
}

TEST_CASE("shadows narrower than the penumbra have a crease, which the mean takes away") {
    // A strip 3 texels wide: half of it is 24 pixels, the penumbra reaches 40.
    const MaskScene mask = mask_scene(LightType::Directional, [](int i) { return i >= -1 && i < 2 ? 32 : -32; });
    Frame frame = mask_frame(mask);
    const float pixel = static_cast<float>(mask.texel_width()) / 16.0f, width = 80 * pixel;
    const std::string common = "edtsm:size=64,mean-width=fixed,penumbra=" + std::to_string(width) + ",kernel=";
    const auto bend = [&](const std::string& kernel) { // second difference at the strip's middle, in slopes of 1/P
        const Image<float> values = shade(frame, mask.light, common + kernel).values;
        int low = 0;
        const Image<float> hard = shade(frame, mask.light, "rbsm-nonc:size=64").values;
        while (hard(low, 128) == 1) ++low;
        const int middle = low + 24;
        const float second = values(middle - 5, 128) + values(middle + 5, 128) - 2 * values(middle, 128);
        return static_cast<double>(second * width / (10 * pixel));
    };
    CHECK(bend("0") == Approx(1.0).margin(0.12)); // slope −1/P before, 1/P after: twice 5 pixels' worth, over 10
    CHECK(bend("15") < 0.9 * bend("0"));
    CHECK(bend("45") < 0.6 * bend("0"));
}

TEST_CASE("surfaces of different depth have no penumbra in common") {
    // The floor's right half is raised; the left one lies in shadow up to the step, so that only the step's depth keeps
    // the penumbra off the right one. Thresholds are 2.5e-3 of a depth range of 2 m: 5 mm.
    const auto darkest_right = [](double step, const char* more) {
        MaskScene mask = mask_scene(LightType::Directional, [](int i) { return i < 0 ? 32 : -32; });
        MeshData raised;
        const auto y = static_cast<float>(step);
        raised.positions = {{0, y, -4}, {4, y, -4}, {4, y, 4}, {0, y, 4}};
        raised.triangles = {{0, 2, 1}, {0, 3, 2}};
        add_object(mask.scene, "raised", raised, dmat4(1.0), 0);
        Frame frame = mask_frame(mask);
        const Image<float> values = shade(frame, mask.light, std::string("edtsm:size=64,penumbra=0.3") + more).values;
        float darkest = 1.0f;
        for (int p = 0; p < mask_pixels; ++p) darkest = std::min(darkest, values(136, p));
        return darkest;
    };
    CHECK(darkest_right(0.02, "") == 1.0f);
    CHECK(darkest_right(0.002, "") < 0.9f);
    CHECK(darkest_right(0.02, ",edge-tests=off") < 0.9f);
}

TEST_CASE("the nearest seed in the world, in the image and by jump flooding agree on a plane seen straight on") {
    const MaskScene mask = mask_scene(LightType::Directional, [](int i) { return i / 3; });
    Frame frame = mask_frame(mask);
    const Visibility exact = shade(frame, mask.light, "edtsm:size=64,penumbra=0.5,kernel=0");
    const auto difference = [&](const char* more) {
        const Visibility other = shade(frame, mask.light, std::string("edtsm:size=64,penumbra=0.5,kernel=0") + more);
        float largest = 0;
        for (size_t i = 0; i < exact.values.size(); ++i)
            largest = std::max(largest, std::abs(exact.values.data()[i] - other.values.data()[i]));
        return largest;
    };
    CHECK(difference(",nearest=world") < 1e-4f);
    CHECK(difference(",transform=jump-flooding") < 0.02f);
    CHECK(difference(",distance=clip") < 1.0f);
}

TEST_CASE("penumbrae keep their width in the world as the viewer comes nearer, unless they count pixels") {
    const Scene scene = box_over_floor();
    const Light light = point_light({0, 4, 0});
    const auto lit_area = [&](double distance,
                              const char* technique) { // half-lit floor, in square metres over the edge
        Camera camera = scene.cameras[0];
        camera.position = vec3(0.0f, 7.0f, 6.0f) * static_cast<float>(distance);
        Frame frame(scene, camera, 480, 360);
        const Visibility visibility = shade(frame, light, technique);
        double least = 1e9, most = -1e9; // x of the penumbra along z ≈ 0, right of the box
        for (size_t i = 0; i < visibility.values.size(); ++i) {
            const Receiver& receiver = frame.receivers().data()[i];
            if (!receiver.valid() || receiver.triangle >= 2 || std::abs(receiver.position.z) > 0.3f) continue;
            const double x = static_cast<double>(receiver.position.x);
            if (x < 0.2 || visibility.values.data()[i] < 0.05f || visibility.values.data()[i] > 0.95f) continue;
            least = std::min(least, x), most = std::max(most, x);
        }
        return most - least;
    };
    const char* world = "edtsm:penumbra=0.4,kernel=0,edge-tests=off";
    CHECK(lit_area(1.0, world) == Approx(0.36).margin(0.04));
    CHECK(lit_area(0.6, world) == Approx(0.36).margin(0.04));
    const char* pixels = "edtsm:distance=screen,penumbra=20,kernel=0,edge-tests=off";
    CHECK(lit_area(0.6, pixels) < 0.75 * lit_area(1.0, pixels));
}
