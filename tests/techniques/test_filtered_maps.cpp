// Filtered maps as techniques draw and read them: lit planes stay lit under every light, sheets whose filters have
// closed forms, and each technique's known artifact in the expected amount.

#include <catch2/catch.hpp>

#include <algorithm>
#include <set>

#include "raster/passes/filter.h"
#include "techniques/moments/bounds.h"
#include "tests/techniques/plates.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

const std::vector<std::string> filtered_techniques = {"pcf", "vsm", "esm", "evsm", "csm-fourier", "gsm", "msm"};

float least_on_floor(const Frame& frame, const Image<float>& visibility) {
    float least = 1.0f;
    int count = 0;
    for (size_t i = 0; i < visibility.size(); ++i) {
        if (!frame.receivers().data()[i].valid()) continue;
        least = std::min(least, visibility.data()[i]);
        ++count;
    }
    CHECK(count > 5000);
    return least;
}

std::vector<Light> lights_of_all_kinds() {
    Light spot = point_light({2, 4, 1});
    spot.type = LightType::Spot;
    spot.direction = glm::normalize(vec3(-2, -4, -1));
    spot.outer_cone = 1.2f;
    Light sun;
    sun.type = LightType::Directional;
    sun.direction = glm::normalize(vec3(1, -1, 0.5f));
    Light panel = point_light({-2, 3, -1});
    panel.type = LightType::Rectangle;
    panel.size = {1, 1};
    return {point_light({1, 5, 2}), spot, sun, panel, point_light({0.3f, 0.8f, -0.2f})};
}

// Seen in its middle: at its far edge no filter knows that it does not go on.
Scene lone_floor() {
    Scene scene;
    scene.materials.push_back({});
    MeshData floor;
    floor.positions = {{-8, 0, -8}, {8, 0, -8}, {8, 0, 8}, {-8, 0, 8}};
    floor.triangles = {{0, 2, 1}, {0, 3, 2}};
    add_object(scene, "floor", floor, dmat4(1.0), 0);
    for (const vec3& p : scene.positions) scene.bounds.extend(p);
    Camera camera = look_at({0.0f, 4.0f, 4.0f}, {0.0f, 0.0f, 0.0f}, 0.8f);
    camera.near_plane = 1.0f;
    camera.far_plane = 30.0f;
    scene.cameras.push_back(camera);
    return scene;
}

// Under a sheet over everything at 1 m lies the floor, and over its left half another sheet at 3.3 m: three layers, of
// which the filter takes the upper ones by the share p that lies on its left.
struct ThreeLayers : PlatesScene {
    ThreeLayers() : PlatesScene(64, {{1.0f, {}}, {3.3f, left_half()}}, 0.5f, 24.0f) {}
    double upper() const { return depth_of(3.3f); }
    double lower() const { return depth_of(1.0f); }
    double floor() const { return depth_of(0.0f); }

    // The largest difference between what a technique says and expected(p), over all pixels.
    template <class Expected>
    double worst(const std::string& text, const std::vector<float>& weights, const Expected& expected) {
        const Image<float> visibility = shade(text).values;
        double worst = 0;
        for (int y = 0; y < visibility.height(); ++y)
            for (int x = 0; x < visibility.width(); ++x) {
                const double p = share_on_the_left(static_cast<double>(place(x, y).x), weights);
                worst = std::max(worst, std::abs(static_cast<double>(visibility(x, y)) - expected(p)));
            }
        return worst;
    }
    // E[f(z)] where the share p of the filter is on the left.
    template <class Function> auto mean(double p, const Function& f) const {
        return f(upper()) * p + f(lower()) * (1 - p);
    }
};

} // namespace

TEST_CASE("a lone plane is lit everywhere, under every light and filter") {
    const Scene scene = lone_floor();
    Frame frame(scene, scene.cameras[0], 160, 120);
    std::vector<std::string> variants = {
        "evsm:components=two",         "evsm:components=published,min-deviation=1e-3",
        "msm:problem=hausdorff",       "msm:format=unorm16,moment-bias=6e-5",
        "gsm:warp=exponential",        "vsm:format=half,min-variance=1e-5,constant-bias=0.002",
        "pcf:taps=bilinear",           "pcf:taps=poisson",
        "pcf:taps=published,radius=4", "vsm:footprint=true",
        "msm:footprint=true",          "vsm:prefilter=mip",
        "msm:prefilter=mip",           "esm:store=exponential,prefilter=sat,sums=double,exponent=15",
        "csm-fourier:blur=gaussian"};
    for (const char* sums : {"double", "uint32", "int64"})
        for (const char* technique : {"vsm", "msm"})
            variants.push_back(std::string(technique) + ":prefilter=sat,sums=" + sums);
    const std::vector<Light> lights = lights_of_all_kinds();
    const auto check = [&](const Light& light, const std::string& technique) {
        INFO(technique << " under the " << light_type_name(light.type) << " light");
        const char separator = technique.find(':') == std::string::npos ? ':' : ',';
        CHECK(least_on_floor(frame, shade(frame, light, technique + separator + "size=256").values) >= 0.999f);
    };
    for (const std::string& technique : filtered_techniques)
        for (const Light& light : lights) check(light, technique);
    for (const std::string& technique : variants)
        for (const Light& light : {lights[1], lights[4]}) check(light, technique); // one view, and a cube close by
}

TEST_CASE("behind two layers every technique bleeds as its formula says") {
    ThreeLayers scene;
    const std::vector<float> weights = binomial_weights(15);
    const double a = scene.upper(), b = scene.lower(), t = scene.floor();
    CAPTURE(a, b, t);
    const auto moments = [&](double p) { return scene.mean(p, [](double z) { return four_moments(z); }); };

    CHECK(scene.worst("vsm:size=64", weights,
                      [&](double p) { return chebyshev(moments(p).x, moments(p).y, t, 1e-6); }) < 1e-4);
    CHECK(scene.worst("vsm:size=64,bleeding=0.3", weights, [&](double p) {
        return reduce_bleeding(chebyshev(moments(p).x, moments(p).y, t, 1e-6), 0.3);
    }) < 2e-4);
    CHECK(scene.worst("gsm:size=64,tail=half", weights,
                      [&](double p) { return gaussian_tail(moments(p).x, moments(p).y, t, 1e-6, 0.5); }) < 2e-4);
    CHECK(scene.worst("esm:size=64,exponent=10", weights, [&](double p) {
        return std::exp(-10 * t) * scene.mean(p, [](double z) { return std::exp(10 * z); });
    }) < 1e-4);
    CHECK(scene.worst("evsm:size=64,positive=4,components=two", weights, [&](double p) {
        const auto warp = [](double z) { return std::exp(4 * (2 * z - 1)); };
        const double least = 1e-3 * 4 * warp(t);
        return chebyshev(scene.mean(p, warp), scene.mean(p, [&](double z) { return warp(z) * warp(z); }), warp(t),
                         least * least);
    }) < 2e-4);
    // Four moments that the blur has rounded answer with what α lets through: within 2e-3 here.
    for (const char* problem : {"hamburger", "hausdorff"}) {
        INFO(problem);
        CHECK(scene.worst("msm:size=64,problem=" + std::string(problem), weights, [&](double p) {
            const dvec4 m = biased(moments(p), 3e-5, moments_of_ends_and_middle<double>);
            return problem == std::string("hamburger") ? hamburger(m, t) : hausdorff(m, t);
        }) < 2e-3);
    }
    CHECK(scene.worst("csm-fourier:size=64,format=float32,offset=0,scale=1,range=1,attenuation=0", weights, [&](double p) {
        const FourierSeries series = {16, 0.0f};
        return saturate(series.value(t, [&](int k) {
            return scene.mean(p, [&](double z) { return FourierSeries::cos_sin(series.frequency(k) * z); });
        }));
    }) < 1e-3);
    // And percentage-closer filtering not at all, whatever its taps.
    for (const char* taps : {"cells", "published", "poisson", "bilinear"})
        CHECK(scene.worst("pcf:size=64,taps=" + std::string(taps), weights, [](double) { return 0.0; }) == 0);
}

TEST_CASE("the amounts of bleeding are those that make the artifacts visible") {
    ThreeLayers scene;
    const auto most = [&](const std::string& text) {
        const Image<float> visibility = scene.shade(text).values;
        return *std::max_element(visibility.values().begin(), visibility.values().end());
    };
    // (t − b)/(t − a) is about 0.3 here: Chebyshev's bound peaks at ((1 − r)/(1 + r))².
    const double r = (scene.floor() - scene.lower()) / (scene.floor() - scene.upper());
    const double peak = (1 - r) * (1 - r) / ((1 + r) * (1 + r));
    CHECK(static_cast<double>(most("vsm:size=64")) == Approx(peak).margin(0.01));
    CHECK(static_cast<double>(most("vsm:size=64")) > 0.25);
    CHECK(most("vsm:size=64,bleeding=0.35") == 0.0f);
    CHECK(most("esm:size=64") < 1e-6f);
    CHECK(most("evsm:size=64") < 1e-3f); // its least deviation alone: (c · 1e-4)²
    CHECK(most("msm:size=64") < 0.01f);
    CHECK(most("csm-fourier:size=64,attenuation=0,offset=0,scale=1,range=1") > 0.01f);
}

TEST_CASE("exponential maps leak at contacts by the distance, and overflow where they are told to") {
    // A sheet 0.1 m over the floor, and one far above beside the view that stretches the depth range.
    PlatesScene scene(64, {{0.1f, left_half()}, {5.0f, {{-32, 20}, {32, 20}, {32, 32}, {-32, 32}}}}, 0.05f, 20.0f);
    const double gap = scene.depth_of(0.0f) - scene.depth_of(0.1f);
    const auto at_left = [&](const std::string& text) {
        const Image<float> visibility = scene.shade(text).values;
        return static_cast<double>(visibility(2, visibility.height() / 2));
    };
    for (const int c : {20, 40, 80}) {
        CAPTURE(c);
        const std::string exponent = ",exponent=" + std::to_string(c);
        CHECK(at_left("esm:size=64,kernel=3" + exponent) == Approx(std::exp(-c * gap)).epsilon(1e-3));
        CHECK(at_left("esm:size=64,kernel=3,store=exponential" + exponent) == Approx(std::exp(-c * gap)).epsilon(2e-3));
    }
    CHECK(at_left("esm:size=64,kernel=3") > 0.15);
    const auto lit = [&](const std::string& text) {
        const Image<float> visibility = scene.shade(text).values;
        return visibility(visibility.width() - 3, visibility.height() / 2);
    };
    CHECK(lit("esm:size=64,store=exponential,exponent=88") > 0.999f);
    CHECK(lit("esm:size=64,store=exponential,exponent=95") == 0.0f); // e^95 is infinite in 32 bits
    CHECK(lit("esm:size=64,store=log,exponent=1000") == 1.0f);
    // The square of e^50 is infinite: where it should be half lit, it is dark.
    const auto half_lit = [&](const std::string& text) {
        const Image<float> visibility = scene.shade(text).values;
        return visibility(visibility.width() / 2, visibility.height() / 2);
    };
    CHECK(half_lit("evsm:size=64,positive=42,components=two") == Approx(0.5).margin(0.05));
    CHECK(half_lit("evsm:size=64,positive=50,components=two") == 0.0f);
}

TEST_CASE("a lit lower step is darkened by the filter's share of the upper one") {
    // Nothing is in shadow: light falls straight down. Filters cannot tell the step from an occluder.
    PlatesScene scene(64, {{1.0f, left_half()}}, 4.0f, 24.0f);
    const std::vector<float> weights = binomial_weights(15);
    for (const char* technique : {"vsm:size=64", "msm:size=64", "evsm:size=64", "esm:size=64"}) {
        INFO(technique);
        const Image<float> visibility = scene.shade(technique).values;
        double worst = 0, least = 1;
        for (int y = 0; y < visibility.height(); ++y)
            for (int x = 0; x < visibility.width(); ++x) {
                const double u = static_cast<double>(scene.place(x, y).x);
                if (u <= 0) {
                    least = std::min(least, static_cast<double>(visibility(x, y)));
                    continue;
                }
                worst = std::max(worst,
                                 std::abs(static_cast<double>(visibility(x, y)) - 1.0 + share_on_the_left(u, weights)));
            }
        CHECK(worst < 0.005);
        CHECK(least > 0.995); // the upper step itself
    }
}

TEST_CASE("hardware bilinear comparisons make a straight ramp of kernel texels") {
    PlatesScene scene(64, {{1.0f, left_half()}}, 0.5f, 24.0f);
    for (const int n : {1, 2, 3, 7}) {
        CAPTURE(n);
        const Image<float> visibility = scene.shade("pcf:size=64,taps=bilinear,kernel=" + std::to_string(n)).values;
        double worst = 0;
        for (int y = 0; y < visibility.height(); ++y)
            for (int x = 0; x < visibility.width(); ++x) {
                const double u = static_cast<double>(scene.place(x, y).x);
                worst = std::max(worst,
                                 std::abs(static_cast<double>(visibility(x, y)) - std::clamp(u / n + 0.5, 0.0, 1.0)));
            }
        CHECK(worst < 2e-5);
        CHECK(scene.frame().log().passes.back().texels_fetched == 4LL * n * n * 256 * 256);
    }
}

TEST_CASE("taps are as many as asked for, on as many levels as they allow") {
    PlatesScene scene(64, {{1.0f, left_half()}}, 0.5f, 24.0f, 128);
    const auto fetches = [&](const std::string& text) {
        scene.shade(text);
        return scene.frame().log().passes.back().texels_fetched / (128 * 128);
    };
    CHECK(fetches("pcf:size=64,kernel=7,radius=1,taps=published") == 7 * 7);
    CHECK(fetches("pcf:size=64,kernel=15,radius=1,taps=published") == 16 * 16);
    CHECK(fetches("pcf:size=64,kernel=15") == 15 * 15);
    CHECK(fetches("pcf:size=64,taps=poisson,samples=33") == 33);
    const Image<float> visibility = scene.shade("pcf:size=64,kernel=7").values;
    std::set<float> levels(visibility.values().begin(), visibility.values().end());
    CHECK(levels.size() == 8);
    for (const float level : levels) CHECK(level * 7 == Approx(std::round(level * 7)));
    // Poisson points cover the square evenly: shifted or not, the mean over pixels follows the ramp.
    for (const char* shift : {"true", "false"}) {
        const Image<float> noisy =
            scene.shade("pcf:size=64,kernel=9,taps=poisson,samples=256,shift=" + std::string(shift)).values;
        double worst = 0;
        for (int x = 0; x < noisy.width(); ++x) {
            double sum = 0;
            for (int y = 0; y < noisy.height(); ++y) sum += static_cast<double>(noisy(x, y));
            // A nearest tap sees the edge where the texel's centre has it.
            const double expected = std::clamp(static_cast<double>(scene.place(x, 0).x) / 9 + 0.5, 0.0, 1.0);
            worst = std::max(worst, std::abs(sum / noisy.height() - expected));
        }
        CAPTURE(shift);
        CHECK(worst < 0.05);
    }
}

TEST_CASE("summed-area tables filter by exactly the box, in any arithmetic") {
    ThreeLayers scene;
    const double a = scene.upper(), b = scene.lower(), t = scene.floor();
    for (const char* sums : {"float", "double", "uint32", "int64"}) {
        INFO(sums);
        const Image<float> visibility =
            scene.shade("vsm:size=64,kernel=9,prefilter=sat,sums=" + std::string(sums)).values;
        double worst = 0;
        for (int y = 0; y < visibility.height(); ++y)
            for (int x = 0; x < visibility.width(); ++x) {
                const double p = std::clamp(0.5 - static_cast<double>(scene.place(x, y).x) / 9, 0.0, 1.0);
                const double expected = chebyshev(p * a + (1 - p) * b, p * a * a + (1 - p) * b * b, t, 1e-6);
                worst = std::max(worst, std::abs(static_cast<double>(visibility(x, y)) - expected));
            }
        CHECK(worst < 1e-3);
    }
    CHECK_THROWS_WITH(scene.shade("evsm:prefilter=sat,sums=uint32"), Catch::Contains("sums=double"));
    CHECK_THROWS_WITH(scene.shade("esm:prefilter=mip"), Catch::Contains("store=exponential"));
}

TEST_CASE("filters that follow a pixel's footprint alias less from afar") {
    const Scene scene = load_scene("builtin:fence");
    Frame coarse(scene, scene.cameras[0], 96, 54), fine(scene, scene.cameras[0], 768, 432);
    const Light& light = scene.lights[0];
    const Image<float> reference = shade(fine, light, "vsm:kernel=3").values;
    const auto error = [&](const std::string& text) {
        const Image<float> visibility = shade(coarse, light, text).values;
        double sum = 0;
        int count = 0;
        for (int y = 0; y < 54; ++y)
            for (int x = 0; x < 96; ++x) {
                double mean = 0;
                bool floor = true;
                for (int k = 0; k < 64; ++k) {
                    const int i = 8 * x + k % 8, j = 8 * y + k / 8;
                    const Receiver& receiver = fine.receivers()(i, j);
                    floor = floor && receiver.valid() && std::abs(receiver.position.y) < 1e-3f;
                    mean += static_cast<double>(reference(i, j)) / 64;
                }
                if (!floor) continue;
                sum += std::pow(static_cast<double>(visibility(x, y)) - mean, 2);
                ++count;
            }
        CHECK(count > 500);
        return std::sqrt(sum / count);
    };
    const double plain = error("vsm:kernel=3"), followed = error("vsm:kernel=3,footprint=true");
    CAPTURE(plain, followed);
    CHECK(followed < 0.8 * plain);
}

TEST_CASE("inner images are named, and filtered maps show their filter") {
    ThreeLayers scene;
    const auto names = [&](const std::string& text) {
        std::string joined;
        for (const NamedImage& image : scene.shade(text).debug) joined += image.name + " ";
        return joined;
    };
    CHECK(names("vsm:size=64") == "moments-1 moments-2 filtered-1 filtered-2 ");
    CHECK(names("esm:size=64") == "moments-1 filtered-1 ");
    CHECK(names("evsm:size=64,components=two") == "moments-1 moments-2 filtered-1 filtered-2 ");
    CHECK(names("msm:size=64,prefilter=sat") == "moments-1 moments-2 moments-3 moments-4 sums-1 sums-2 sums-3 sums-4 ");
    const Visibility vsm = scene.shade("vsm:size=64");
    CHECK(vsm.debug[0].values(31, 32) == Approx(scene.upper()));
    CHECK(vsm.debug[0].values(32, 32) == Approx(scene.lower()));
    CHECK(vsm.debug[2].values(32, 32) ==
          Approx(scene.lower() + share_on_the_left(0.5, binomial_weights(15)) * (scene.upper() - scene.lower())));
}
