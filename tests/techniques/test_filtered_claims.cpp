// What the thesis claims of filtered shadow maps, checked: data/studies/macedo2018-claims.json refers to these tests
// and has the figures that they print, docs/results-macedo2018.md what becomes of each claim.

#include <catch2/catch.hpp>

#include <map>
#include <set>

#include "techniques/moments/bounds.h"
#include "tests/support.h"
#include "tests/techniques/plates.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

// A half-plane whose edge rises one texel in four on a map of a texel a tenth of a metre.
struct SlopedEdge : PlatesScene {
    SlopedEdge() : PlatesScene(64, {{1.0f, below_edge()}}, 0.5f, 24.0f, 384) {}

    // v = u/4 − ½, where the map's texels in shadow are those below ⌊u/4⌋.
    static std::vector<vec2> below_edge() {
        const auto v = [](float u) { return 0.25f * u - 0.5f; };
        return {{-32, 32}, {32, 32}, {32, -v(32)}, {-32, -v(-32)}}; // z is −v
    }

    // ∫ of the standard deviation along the edge over vertical offsets from it, in texels. Offsets are taken in bins of
    // 1/8 texel, over whole periods of the staircase. [Macedo 2018, 3.5 of the specification]
    double jaggedness(const Image<float>& visibility) const {
        struct Bin {
            double sum = 0, squares = 0;
            int count = 0;
        };
        std::map<int, Bin> bins;
        for (int y = 0; y < visibility.height(); ++y)
            for (int x = 0; x < visibility.width(); ++x) {
                const vec2 p = place(x, y);
                const double offset = static_cast<double>(p.y) - (0.25 * static_cast<double>(p.x) - 0.5);
                if (std::abs(p.x) >= 8.0f || std::abs(offset) >= 9.0) continue;
                const double value = static_cast<double>(visibility(x, y));
                Bin& bin = bins[static_cast<int>(std::floor(offset * 8))];
                bin.sum += value, bin.squares += value * value, ++bin.count;
            }
        double integral = 0;
        for (const auto& [at, bin] : bins) {
            const double mean = bin.sum / bin.count;
            integral += std::sqrt(std::max(0.0, bin.squares / bin.count - mean * mean)) / 8;
        }
        return integral;
    }
};

} // namespace

TEST_CASE("claim C12, filtering alone leaves the steps of a coarse map in its penumbra") {
    SlopedEdge scene;
    const auto jaggedness = [&](const std::string& text) {
        const double value = scene.jaggedness(scene.shade(text).values);
        WARN(text << ": J = " << value << " texels");
        return value;
    };
    const double hard = jaggedness("sm:size=64");
    CHECK(hard == Approx(pi / 8).margin(0.03));
    // The same integral over the mask itself, evaluated apart from this program. With taps 2 radius/(kernel − 1) apart,
    // from edge to edge, it is 0.188, 0.168 and 0.258, which the specification has as 0.20, 0.17 and 0.25.
    CHECK(jaggedness("pcf:size=64,kernel=7,radius=1") == Approx(0.194).margin(0.015));
    CHECK(jaggedness("pcf:size=64,kernel=15,radius=1") == Approx(0.185).margin(0.015));
    CHECK(jaggedness("pcf:size=64,kernel=7,radius=3.5") == Approx(0.302).margin(0.015));
    for (const char* technique : {"vsm", "esm", "evsm", "msm", "gsm"}) {
        const double filtered = jaggedness(std::string(technique) + ":size=64,kernel=3");
        CHECK(filtered > 0.05);
        CHECK(filtered < hard);
    }
}

TEST_CASE("claim C13, variance bleeds most, percentages never, but four moments more than two exponentials") {
    // A sheet over everything, another over half of it: the umbra is everywhere. Depths as the specification's case C
    // has them in proportion, and its case D with a third layer.
    PlatesScene two(64, {{0.5f, {}}, {4.5f, left_half()}}, 0.25f, 24.0f);
    PlatesScene three(64, {{1.5f, {}}, {3.0f, left_half()}, {4.5f, {{-999, -999}, {-2, -999}, {-2, 999}, {-999, 999}}}},
                      0.25f, 24.0f);
    const auto leak = [&](PlatesScene& scene, const std::string& text) {
        const Image<float> visibility = scene.shade(text).values;
        double sum = 0;
        for (const float v : visibility.values()) sum += static_cast<double>(v);
        const double mean = sum / static_cast<double>(visibility.size());
        WARN(text << ": mean light in the umbra " << mean << (&scene == &two ? ", two layers" : ", three layers"));
        return mean;
    };
    for (PlatesScene* scene : {&two, &three}) {
        const double vsm = leak(*scene, "vsm:size=64"), evsm = leak(*scene, "evsm:size=64");
        const double msm = leak(*scene, "msm:size=64"), gsm = leak(*scene, "gsm:size=64");
        CHECK(vsm > 1000 * evsm);
        CHECK(vsm > 5 * msm);
        CHECK(vsm > gsm);
        CHECK(evsm < msm); // the claim has it the other way round
        leak(*scene, "msm:size=64,format=unorm16");
        leak(*scene, "esm:size=64");
        leak(*scene, "csm-fourier:size=64");
        CHECK(leak(*scene, "pcf:size=64") == 0);
    }
}

TEST_CASE("claim C13 in whole scenes, light left deep in the umbra") {
    const bool mesh = GENERATE(false, true);
    const std::string path = mesh ? shared_path("scenes/bunny/bunny.glb") : "builtin:stacked-plates";
    if (path.empty()) return;
    const Scene scene = load_scene(path);
    const int width = 480, height = 270, reach = 8;
    Frame frame(scene, scene.cameras[0], width, height);
    const Light& light = scene.lights[0];
    const Image<float> truth = shade(frame, light, "raytraced").values;
    // Umbra that faces the light, all of whose neighbours within 8 pixels are umbra.
    Image<std::uint8_t> deep(width, height, std::uint8_t{0});
    const auto umbra = [&](int x, int y) { return truth(x, y) == 0.0f; };
    std::int64_t count = 0;
    for (int y = reach; y < height - reach; ++y)
        for (int x = reach; x < width - reach; ++x) {
            const Receiver& receiver = frame.receivers()(x, y);
            if (!receiver.valid() || !umbra(x, y) || !faces_light(receiver, light)) continue;
            deep(x, y) = !changes_nearby(x, y, width, height, reach, umbra);
            count += deep(x, y);
        }
    REQUIRE(count > 200);
    const auto leak = [&](const std::string& text) {
        const Image<float> visibility = shade(frame, light, text).values;
        double sum = 0;
        for (size_t i = 0; i < deep.size(); ++i)
            if (deep.data()[i]) sum += static_cast<double>(visibility.data()[i]);
        WARN(scene.name << ", " << count << " pixels, " << text << ": " << sum / static_cast<double>(count));
        return sum / static_cast<double>(count);
    };
    // 7x7 taps are as wide as the binomial 15x15 blur: sigma 2.0 and 1.9 texels.
    const double pcf = leak("pcf"), narrow_pcf = leak("pcf:kernel=7"), vsm = leak("vsm");
    const double msm = leak("msm"), unbiased_msm = leak("msm:plane-bias=0");
    for (const char* technique : {"evsm", "evsm:plane-bias=0", "esm", "gsm"}) leak(technique);
    CHECK(vsm > unbiased_msm);
    if (mesh) {
        // Creases, where 15 taps reach the light and a plane's bias lifts its receiver past the blocker.
        CHECK(pcf > narrow_pcf);
        CHECK(msm > unbiased_msm);
    } else {
        CHECK(vsm > 5 * pcf);
        CHECK(vsm > 5 * msm);
    }
}

TEST_CASE("claim C15, PCF bands by its taps along an edge") {
    SlopedEdge sloped;
    PlatesScene straight(64, {{1.0f, left_half()}}, 0.5f, 24.0f);
    const auto levels = [&](PlatesScene& scene, const std::string& text) {
        const Image<float> visibility = scene.shade(text).values;
        return std::set<float>(visibility.values().begin(), visibility.values().end()).size();
    };
    CHECK(levels(straight, "pcf:size=64,kernel=7") == 8);
    CHECK(levels(straight, "pcf:size=64,kernel=15") == 16);
    const size_t seven = levels(sloped, "pcf:size=64,kernel=7"), fifteen = levels(sloped, "pcf:size=64,kernel=15");
    WARN("levels along slope 1/4: PCF 7x7 " << seven << ", PCF 15x15 " << fifteen);
    CHECK(seven > 8);
    CHECK(fifteen > seven);
    CHECK(levels(straight, "vsm:size=64,kernel=15") > 100);
}

TEST_CASE("claim C16, percentages cost the square of the kernel, filtered maps its side, their look-ups nothing") {
    PlatesScene scene(64, {{1.0f, left_half()}}, 0.5f, 24.0f, 64);
    const auto exponent = [&](const std::string& technique, const std::string& pass) {
        double first = 0, last = 0;
        for (const int kernel : {7, 31}) {
            scene.shade(technique + ":size=64,kernel=" + std::to_string(kernel));
            for (const PassCounters& counters : scene.frame().log().passes)
                if (counters.name == pass) (kernel == 7 ? first : last) = static_cast<double>(counters.texels_fetched);
        }
        return std::log(last / first) / std::log(31.0 / 7.0);
    };
    CHECK(exponent("pcf", "look-up") == Approx(2.0));
    for (const char* technique : {"vsm", "esm", "evsm", "msm", "gsm", "csm-fourier"}) {
        INFO(technique);
        CHECK(exponent(technique, "blur") == Approx(1.0));
        CHECK(exponent(technique, "look-up") == Approx(0.0).margin(1e-12));
    }
    // Summed-area tables: whatever the kernel.
    scene.shade("vsm:size=64,prefilter=sat,kernel=31");
    const std::int64_t large = scene.frame().log().passes[1].texels_fetched;
    scene.shade("vsm:size=64,prefilter=sat,kernel=7");
    CHECK(scene.frame().log().passes[1].texels_fetched == large);
}

TEST_CASE("claim C20, a fixed penumbra is farther from an area light's than PCSS") {
    const Scene scene = load_scene("builtin:half-plane");
    Frame frame(scene, scene.cameras[0], 240, 135);
    const Light& light = scene.lights[0];
    const Image<float> truth = shade(frame, light, "truth:samples=1024").values;
    const auto error = [&](const std::string& text) {
        const double value = facing_rmse(frame, light, shade(frame, light, text).values, truth);
        WARN(text << ": RMSE " << value);
        return value;
    };
    const double pcss = error("pcss:size=512,kernel=15");
    for (const char* technique : {"pcf", "vsm", "esm", "evsm", "msm", "gsm", "csm-fourier"})
        CHECK(error(std::string(technique) + ":size=512") > pcss);
}
