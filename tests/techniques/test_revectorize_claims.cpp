// Claims of the thesis on revectorization, each checked and its figure told. data/studies/macedo2018-claims.json has
// the figures, docs/results-macedo2018.md what they say. [Macedo 2018, 3.6]

#include <catch2/catch.hpp>

#include <cmath>
#include <random>
#include <set>

#include "core/primitives.h"
#include "techniques/revectorize/edt_penumbra.h"
#include "tests/techniques/mask_scene.h"
#include "tests/techniques/masks.h"
#include "tests/techniques/shading.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

// How a variant draws the half-plane v < slope·u + shift from its mask: offsets are vertical, in texels, per texel
// along u.
struct EdgeErrors {
    double jaggedness = 0; // ∫ of the standard deviation of V along the edge over offsets from it
    double offset = 0;     // ∫ of V − truth: negative where the shadow is too large
    double absolute = 0;   // ∫ of |V − truth|
    double square = 0;     // ∫ of (V − truth)²
};

EdgeErrors edge_errors(Variant variant, float slope, float shift) {
    const MaskSource mask{
        [=](int i, int j) { return static_cast<float>(j) + 0.5f < slope * (static_cast<float>(i) + 0.5f) + shift; }};
    EdgeErrors errors;
    constexpr int along = 256;
    constexpr float step = 1.0f / 16;
    for (float t = -2.5f + step / 2; t < 2.5f; t += step) {
        double sum = 0, squares = 0;
        for (int k = 0; k < along; ++k) {
            const float u = 0.3819660f * static_cast<float>(k) + 0.1234f;
            const auto v = static_cast<double>(visibility_at(mask, variant, {u, slope * u + shift + t}));
            const double truth = t < 0 ? 0 : 1;
            sum += v, squares += v * v;
            errors.offset += (v - truth) * static_cast<double>(step) / along;
            errors.absolute += std::abs(v - truth) * static_cast<double>(step) / along;
            errors.square += (v - truth) * (v - truth) * static_cast<double>(step) / along;
        }
        const double mean = sum / along;
        errors.jaggedness += std::sqrt(std::max(0.0, squares / along - mean * mean)) * static_cast<double>(step);
    }
    return errors;
}

std::int64_t fetches(Frame& frame, const char* pass) {
    std::int64_t sum = 0;
    for (const PassCounters& counters : frame.log().passes)
        if (counters.name == pass) sum += counters.texels_fetched;
    return sum;
}

} // namespace

TEST_CASE("claims C1 to C4: half-planes of random slopes") {
    const unsigned seed = 314;
    INFO("seed " << seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> slopes(0.08f, 1.0f), shifts(0.0f, 1.0f);
    EdgeErrors sum[4];
    double worst_ratio = 0, least_sm = 1e9;
    constexpr int edges = 60;
    for (int k = 0; k < edges; ++k) {
        const float slope = slopes(random), shift = shifts(random);
        EdgeErrors of[4];
        for (int v = 0; v < 4; ++v) {
            of[v] = edge_errors(static_cast<Variant>(v), slope, shift);
            sum[v].jaggedness += of[v].jaggedness / edges, sum[v].offset += of[v].offset / edges;
            sum[v].absolute += of[v].absolute / edges, sum[v].square += of[v].square / edges;
        }
        worst_ratio = std::max(worst_ratio, of[2].jaggedness / of[0].jaggedness);
        least_sm = std::min(least_sm, of[0].jaggedness);
    }
    constexpr const char* names[] = {"sm", "rbsm-cons", "rbsm-nonc", "rbsm-filt"};
    for (int v = 0; v < 4; ++v)
        WARN(names[v] << ": jaggedness " << sum[v].jaggedness << ", offset " << sum[v].offset << ", absolute error "
                      << sum[v].absolute << ", square error " << sum[v].square);
    WARN("jaggedness of rbsm-nonc at worst " << worst_ratio << " of sm's on one slope; sm's least " << least_sm);
    CHECK(least_sm > 0.3);                               // C1
    CHECK(sum[2].jaggedness <= 0.4 * sum[0].jaggedness); // C2
    CHECK(sum[1].jaggedness <= 0.4 * sum[0].jaggedness);
    CHECK(sum[3].jaggedness < sum[2].jaggedness);
    CHECK(sum[1].offset == Approx(-0.5).margin(0.03)); // C3
    CHECK(sum[2].offset == Approx(0.0).margin(0.02));
    CHECK(sum[0].offset == Approx(0.0).margin(0.02));
    CHECK(sum[2].absolute <= 0.14); // C4
    CHECK(sum[0].absolute == Approx(0.28).margin(0.03));
    CHECK(sum[1].absolute == Approx(0.5).margin(0.03));
    CHECK(sum[1].square > sum[0].square); // smoother, but further from the truth than sm
}

TEST_CASE("claim C5: error falls as the map grows") {
    const Scene scene = load_scene("builtin:fence");
    Frame frame(scene, scene.cameras[0], 640, 360);
    const Light& light = scene.lights[0];
    const Image<float> rays = shade(frame, light, "raytraced").values;
    double last = 1, mean_ratio = 1;
    for (const int size : {512, 1024, 2048, 4096}) {
        const double rmse =
            facing_rmse(frame, light, shade(frame, light, "rbsm-nonc:size=" + std::to_string(size)).values, rays);
        WARN("fence: rbsm-nonc " << size << " has RMSE " << rmse);
        CHECK(rmse < last);
        if (size > 512) mean_ratio *= rmse / last;
        last = rmse;
    }
    WARN("per doubling: " << std::cbrt(mean_ratio));
}

TEST_CASE("claim C6: revectorization repairs no wire that is thinner than a texel") {
    const Scene scene = load_scene("builtin:wire-ball");
    Frame frame(scene, scene.cameras[0], 640, 360);
    const Light& light = scene.lights[0];
    const Image<float> rays = shade(frame, light, "raytraced").values;
    const auto errors = [&](const char* technique) {
        const Image<float> values = shade(frame, light, technique).values;
        double over = 0, under = 0;
        for (size_t i = 0; i < values.size(); ++i) {
            const double d = static_cast<double>(values.data()[i]) - static_cast<double>(rays.data()[i]);
            (d < 0 ? over : under) += std::abs(d) / static_cast<double>(values.size());
        }
        WARN(technique << ": too dark " << over << ", too light " << under);
        return vec2(over, under);
    };
    const vec2 sm = errors("sm:size=256"), nonc = errors("rbsm-nonc:size=256"), cons = errors("rbsm-cons:size=256");
    CHECK(cons.x > sm.x);
    CHECK(nonc.x + nonc.y > 0.5f * (sm.x + sm.y)); // nothing like a repair
}

TEST_CASE("claims C8 to C10: memory and fetches") {
    const Scene scene = load_scene("builtin:default");
    Frame frame(scene, scene.cameras[0], 640, 360);
    const Light& light = scene.lights[0];
    const auto peak = [&] { return frame.log().memory->peak(); };
    shade(frame, light, "sm:size=1024");
    const std::int64_t sm_memory = peak();
    const double receivers = static_cast<double>(fetches(frame, "look-up"));
    for (const char* technique : {"rbsm-cons", "rbsm-nonc", "rbsm-filt", "rpcf", "rpcf-opt"}) {
        INFO(technique);
        shade(frame, light, std::string(technique) + ":size=1024");
        CHECK(peak() == sm_memory); // C8
    }
    const auto measure = [&](const char* technique, int size) {
        const Visibility visibility = shade(frame, light, std::string(technique) + ":size=" + std::to_string(size));
        double silhouette = 0;
        for (const float bits : debug_image(visibility, "discontinuities").values()) silhouette += bits != 0;
        const auto fetched = static_cast<double>(fetches(frame, "revectorize"));
        const double per_silhouette = (fetched - 5 * receivers) / silhouette;
        WARN(technique << " " << size << ": " << fetched / receivers << " fetches a receiver, silhouette "
                       << silhouette / receivers << " of them, " << per_silhouette << " more there");
        CHECK(fetched / receivers <= 5 + silhouette / receivers * 325); // C9
        return fetched / receivers;
    };
    for (const int size : {512, 1024, 2048})
        CHECK(measure("rbsm-nonc", size) <= 2.5 * measure("rbsm-cons", size)); // C10
}

TEST_CASE("claim C13: no light leaks into the umbra") {
    const Scene scene = load_scene("builtin:stacked-plates");
    Frame frame(scene, scene.cameras[0], 640, 360);
    const Light& light = scene.lights[0];
    const Image<float> rays = shade(frame, light, "raytraced").values;
    const auto lit = [&](int x, int y) { return rays(x, y) > 0; };
    for (const char* technique : {"rbsm-cons", "rbsm-nonc", "rbsm-filt", "rpcf", "rpcf-opt", "rpcf-hard", "edtsm"}) {
        const Image<float> values = shade(frame, light, technique).values;
        const int reach = technique == std::string("edtsm") ? 24 : 8; // beyond the penumbra that is meant to be there
        double leak = 0;
        int umbra = 0;
        for (int y = 0; y < frame.height(); ++y)
            for (int x = 0; x < frame.width(); ++x) {
                if (lit(x, y) || changes_nearby(x, y, frame.width(), frame.height(), reach, lit)) continue;
                ++umbra;
                leak += static_cast<double>(values(x, y));
            }
        WARN(technique << ": mean visibility " << leak / umbra << " in " << umbra << " umbra pixels " << reach
                       << " pixels from any light");
        CHECK(umbra > 500);
        CHECK(leak == 0.0);
    }
}

TEST_CASE("claim C15: rpcf has more levels than pcf of twice its kernel, on slopes") {
    const MaskScene mask = mask_scene(LightType::Directional,
                                      [](int i) { return static_cast<int>(std::floor(static_cast<double>(i) / 4)); });
    Frame frame = mask_frame(mask);
    const auto levels = [&](const char* technique) {
        const Image<float> values = shade(frame, mask.light, technique).values;
        std::set<float> distinct;
        float step = 0;
        for (int y = 1; y < mask_pixels; ++y)
            for (int x = 96; x < 160; ++x) {
                distinct.insert(values(x, y));
                step = std::max(step, std::abs(values(x, y) - values(x, y - 1)));
            }
        WARN(technique << ": " << distinct.size() << " levels, largest step between pixels 1/16 texel apart " << step);
        return std::pair(distinct.size(), step);
    };
    const auto rpcf = levels("rpcf:size=64"), pcf = levels("pcf:size=64,kernel=15,radius=1");
    CHECK(rpcf.first > pcf.first);
    CHECK(rpcf.second <= 1.0f / 15);
}

TEST_CASE("claims C16 and C17: fetches by kernel and by size of the map") {
    const MaskScene mask = mask_scene(LightType::Directional, [](int i) { return i / 3; });
    Frame frame = mask_frame(mask);
    const auto exponent = [&](const char* technique, const char* pass) {
        const auto of = [&](int kernel) {
            shade(frame, mask.light, std::string(technique) + ":size=64,kernel=" + std::to_string(kernel));
            return std::log(static_cast<double>(fetches(frame, pass)));
        };
        const double slope = (of(15) - of(7)) / std::log(15.0 / 7.0);
        WARN(technique << ": fetches grow with kernel to the power " << slope);
        return slope;
    };
    CHECK(exponent("pcf", "look-up") == Approx(2.0).margin(0.05));
    CHECK(exponent("rpcf", "filter") == Approx(2.0).margin(0.05));
    CHECK(exponent("edtsm", "mean") <= 1.05);

    const auto after_the_map = [&](int size) {
        shade(frame, mask.light, "edtsm:size=" + std::to_string(size));
        std::int64_t sum = 0;
        for (const char* pass : {"seeds", "distance transform", "distances", "normalize", "mean"})
            sum += fetches(frame, pass);
        return static_cast<double>(sum);
    };
    const double small = after_the_map(64), large = after_the_map(1024);
    WARN("edtsm after its hard shadows: " << small << " fetches with 64 texels, " << large << " with 1024");
    CHECK(large == Approx(small).epsilon(0.02));
}

TEST_CASE("claim C14: no penumbra pixel has its seed on another object") {
    const Scene scene = load_scene("builtin:default");
    Frame frame(scene, scene.cameras[0], 640, 360);
    const Light& light = scene.lights[0];
    const Visibility edt = shade(frame, light, "edtsm:size=1024,kernel=0");
    EdtParams params;
    const Image<float>& hard = debug_image(edt, "hard");
    const ShadowImage image = shadow_image(frame, light, params, hard);
    const Image<std::uint8_t> seeds = silhouette_seeds(frame, params, image);
    const Image<Site> sites = nearest_silhouette(frame, params, seeds);
    int penumbra = 0, elsewhere = 0;
    for (int y = 0; y < frame.height(); ++y)
        for (int x = 0; x < frame.width(); ++x) {
            if (edt.values(x, y) == hard(x, y)) continue;
            ++penumbra;
            const auto object = [&](int i, int j) { return scene.triangle_objects[frame.receivers()(i, j).triangle]; };
            elsewhere += object(x, y) != object(sites(x, y).x, sites(x, y).y);
        }
    WARN("edtsm: " << elsewhere << " of " << penumbra << " penumbra pixels have their seed on another object");
    CHECK(penumbra > 5000);
    CHECK(elsewhere < 0.05 * penumbra);
}

namespace {

// A rectangle turned by 20 degrees over a floor, under a light straight down: sides in texels of the mask's map.
struct TurnedRectangle {
    dvec2 half;
    double cosine = std::cos(0.349), sine = std::sin(0.349);
    bool contains(dvec2 p) const {
        const dvec2 q(cosine * p.x + sine * p.y, cosine * p.y - sine * p.x);
        return std::abs(q.x) < half.x && std::abs(q.y) < half.y;
    }
    MaskScene scene() const {
        MaskScene mask = mask_scene(LightType::Directional, [](int) { return -mask_side; });
        MeshData sheet;
        for (const dvec2 corner : {dvec2(-1, -1), dvec2(1, -1), dvec2(1, 1), dvec2(-1, 1)}) {
            const dvec2 q = corner * half;
            sheet.positions.push_back(vec3(mask.world(cosine * q.x - sine * q.y, sine * q.x + cosine * q.y, 1.0)));
        }
        sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
        add_object(mask.scene, "rectangle", sheet, dmat4(1.0), 0);
        for (const vec3& p : mask.scene.positions) mask.scene.bounds.extend(p);
        return mask;
    }
};

} // namespace

TEST_CASE("claim C19: rpcf is nearer to the blurred exact shadow than edtsm") {
    constexpr double reach = 1.5; // texels, half the penumbra
    for (const dvec2 half : {dvec2(5.3, 4.2), dvec2(6.1, 1.2)}) {
        const TurnedRectangle rectangle{half};
        const MaskScene mask = rectangle.scene();
        Frame frame = mask_frame(mask);
        Image<float> blurred(mask_pixels, mask_pixels);
        constexpr int taps = 24;
        for (size_t i = 0; i < blurred.size(); ++i) {
            const dvec2 at(mask.texels(frame.receivers().data()[i].position));
            int dark = 0;
            for (int b = 0; b < taps; ++b)
                for (int a = 0; a < taps; ++a)
                    dark += rectangle.contains(at + reach * ((dvec2(a, b) + 0.5) * (2.0 / taps) - 1.0));
            blurred.data()[i] = 1.0f - static_cast<float>(dark) / (taps * taps);
        }
        const auto rmse = [&](const std::string& technique) {
            const double value = facing_rmse(frame, mask.light, shade(frame, mask.light, technique).values, blurred);
            WARN("rectangle of " << 2 * half.x << " by " << 2 * half.y << " texels: " << technique << " " << value);
            return value;
        };
        const double width = 2 * reach * mask.texel_width();
        const double rpcf = rmse("rpcf:size=64,penumbra=1.5"), pcf = rmse("pcf:size=64,kernel=7,radius=1.5");
        const double edtsm = rmse("edtsm:size=64,mean-width=fixed,kernel=15,penumbra=" + std::to_string(width));
        CHECK(rpcf <= edtsm);
        CHECK(pcf > 0);
    }
}

TEST_CASE("claim C20: a fixed penumbra is not an area light's") {
    const Scene scene = load_scene("builtin:stacked-plates");
    Frame frame(scene, scene.cameras[0], 320, 180);
    const Light& light = scene.lights[0];
    const Image<float> truth = shade(frame, light, "truth:samples=256").values;
    const auto rmse = [&](const char* technique) {
        const double value = facing_rmse(frame, light, shade(frame, light, technique).values, truth);
        WARN(scene.name << ": " << technique << " has RMSE " << value);
        return value;
    };
    const double pcss = rmse("pcss");
    CHECK(rmse("rpcf") > pcss);
    CHECK(rmse("rpcf:penumbra=4") > pcss);
    CHECK(rmse("edtsm") > pcss);
}
