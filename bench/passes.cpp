// Passes over images and the look-ups of shadow maps: each beside what a user would write instead, plain loops without
// counters, borders or formats; and revectorization beside the plain shadow map that it starts from. Rates go to
// standard error.

#include <cmath>
#include <filesystem>
#include <type_traits>

#include <fmt/format.h>

#include "bench/bench.h"
#include "bench/scenes.h"
#include "core/parallel.h"
#include "core/random.h"
#include "raster/passes/distance_transform.h"
#include "raster/passes/summed_area.h"
#include "techniques/map/shadow_map.h"
#include "techniques/technique.h"

namespace gnomon_bench {
namespace {

constexpr int side = 2048; // of maps
constexpr int width = 1280, height = 720, kernel = 15;

void print_rate(const Bench& bench, const std::string& name, double count, const char* what) {
    const double seconds = bench.last_ms() / 1e3;
    fmt::print(stderr, "{}: {:.0f} M {}/s\n", name, count / seconds / 1e6, what);
}

// About the silhouettes that a frame has: thin closed curves, one pixel in a hundred.
Image<std::uint8_t> curves() {
    Image<std::uint8_t> seeds(side, side);
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            const double wave = std::sin(x * 0.011) + std::sin(y * 0.013 + std::sin(x * 0.007));
            seeds(x, y) = std::abs(wave) < 0.008;
        }
    return seeds;
}

// Squared distances along one line of f: the lower envelope of its parabolas, in float. [Felzenszwalb & Huttenlocher
// 2012, algorithm 1]
void distances_1d(const float* f, std::ptrdiff_t stride, int n, float* out, std::vector<int>& at,
                  std::vector<float>& from) {
    int k = -1;
    const auto value = [&](int i) { return f[i * stride]; };
    for (int q = 0; q < n; ++q) {
        if (value(q) >= 1e20f) continue;
        float s = -infinity;
        while (k >= 0) {
            const int p = at[static_cast<size_t>(k)];
            s = ((value(q) + static_cast<float>(q * q)) - (value(p) + static_cast<float>(p * p))) /
                static_cast<float>(2 * q - 2 * p);
            if (s > from[static_cast<size_t>(k)]) break;
            --k;
            s = -infinity;
        }
        ++k;
        at[static_cast<size_t>(k)] = q;
        from[static_cast<size_t>(k)] = s;
    }
    int j = 0;
    for (int q = 0; q < n; ++q) {
        while (j < k && from[static_cast<size_t>(j + 1)] < static_cast<float>(q)) ++j;
        const int p = at[static_cast<size_t>(j)];
        out[q] = k < 0 ? 1e20f : static_cast<float>((q - p) * (q - p)) + value(p);
    }
}

Image<float> plain_distances(const Image<std::uint8_t>& seeds) {
    Image<float> columns(side, side), result(side, side);
    for (size_t i = 0; i < seeds.size(); ++i) result.data()[i] = seeds.data()[i] ? 0.0f : 1e20f;
    parallel_for(side, 16, [&](size_t begin, size_t end) {
        std::vector<int> at(side);
        std::vector<float> from(side), line(side);
        for (size_t x = begin; x < end; ++x) {
            distances_1d(&result(static_cast<int>(x), 0), side, side, line.data(), at, from);
            for (int y = 0; y < side; ++y) columns(static_cast<int>(x), y) = line[static_cast<size_t>(y)];
        }
    });
    parallel_for(side, 16, [&](size_t begin, size_t end) {
        std::vector<int> at(side);
        std::vector<float> from(side);
        for (size_t y = begin; y < end; ++y) {
            const int row = static_cast<int>(y);
            distances_1d(&columns(0, row), 1, side, &result(0, row), at, from);
        }
    });
    return result;
}

void bench_distance_transform(Bench& bench) {
    const std::string name = fmt::format("exact distance transform {0}x{0}", side);
    if (!bench.wanted(name)) return;
    const Image<std::uint8_t> seeds = curves();
    PassLog log;
    Image<Site> sites;
    Image<float> theirs;
    const auto transform = [&] {
        Pass pass(log, "distance transform");
        sites = nearest_seeds(pass, seeds);
    };
    const char* peer = "Felzenszwalb-Huttenlocher in float, distances alone";
    bench.run(name, transform, peer, [&] { theirs = plain_distances(seeds); });
    Pass pass(log, "distances");
    const Image<std::int32_t> ours = squared_distances(pass, sites);
    double our_sum = 0, their_sum = 0;
    for (size_t i = 0; i < ours.size(); ++i)
        our_sum += ours.data()[i], their_sum += static_cast<double>(theirs.data()[i]);
    bench.agree(name, our_sum, their_sum, 1e-6);
    print_rate(bench, name, static_cast<double>(side) * side, "texels");
}

// Rows, then columns, a stripe of them at a time.
template <size_t channels> std::vector<double> plain_sums(const Target& source) {
    std::vector<double> sums(static_cast<size_t>(side) * side * channels);
    const auto row = [&](size_t y) { return sums.data() + y * side * channels; };
    parallel_for(side, 16, [&](size_t begin, size_t end) {
        for (size_t y = begin; y < end; ++y) {
            const float* values = source.row<float>(static_cast<int>(y));
            double sum[channels] = {};
            for (size_t i = 0; i < side * channels; i += channels)
                for (size_t c = 0; c < channels; ++c) row(y)[i + c] = sum[c] += static_cast<double>(values[i + c]);
        }
    });
    parallel_for(side * channels, 64, [&](size_t begin, size_t end) {
        for (size_t y = 1; y < side; ++y)
            for (size_t i = begin; i < end; ++i) row(y)[i] += row(y - 1)[i];
    });
    return sums;
}

template <class T, size_t channels = 1> void bench_summed_area(Bench& bench, const char* arithmetic) {
    const std::string name = fmt::format("summed-area table {0}x{0} {1}", side, arithmetic);
    if (!bench.wanted(name)) return;
    PassLog log;
    Target source(channels == 1 ? Format::R32F : Format::RGBA32F, side, side, 1, log.memory);
    for (int y = 0; y < side; ++y)
        for (size_t i = 0; i < side * channels; ++i)
            source.row<float>(y)[i] = to_unit(hash(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(y), 1u));
    double ours = 0, theirs = 0;
    const SummedAreaOptions options = {.fraction_bits = std::is_same_v<T, std::uint32_t> ? 10 : 20}; // no wrapping
    bench.run(
        name,
        [&] {
            Pass pass(log, "sat");
            const SummedArea<T> table = summed_area<T>(pass, source, options);
            ours = static_cast<double>(table.sum(side - 1, side - 1, channels - 1)) * table.unit;
        },
        "plain loops, double", [&] { theirs = plain_sums<channels>(source).back(); });
    bench.agree(name, ours, theirs, 1e-5);
    print_rate(bench, name, static_cast<double>(side) * side, "texels");
}

// The kernel on the map's rows, which are all inside here.
float plain_kernel(const ShadowMap& map, const MapPoint& point) {
    int lit = 0;
    const int x0 = static_cast<int>(std::floor(point.texel.x)) - kernel / 2;
    const int y0 = static_cast<int>(std::floor(point.texel.y)) - kernel / 2;
    for (int y = y0; y < y0 + kernel; ++y) {
        const float* row = map.depth.row<float>(y, point.layer);
        for (int x = x0; x < x0 + kernel; ++x) lit += point.depth_at(x, y) <= row[x];
    }
    return static_cast<float>(lit) / (kernel * kernel);
}

double mean(const Image<float>& image) {
    double sum = 0;
    for (const float v : image.values()) sum += static_cast<double>(v);
    return sum / static_cast<double>(image.size());
}

// Hills that fill the view, lit from above: every pixel makes all its tests.
void bench_percentage_closer(Bench& bench) {
    const std::string name = fmt::format("pcf look-up {0}x{0} {1}x{2}", kernel, width, height);
    if (!bench.wanted(name)) return;
    Scene scene = height_field();
    scene.lights.front().position = {1, 25, 1};
    scene.cameras.front() = look_at({0, 11, 4}, {0, 0, 0}, 0.7853982f);
    fit_planes(scene.cameras.front(), scene.bounds);
    Frame frame(scene, scene.cameras.front(), width, height);
    const Light& light = scene.lights.front();
    const ShadowMap map = draw_shadow_map(frame, light, FilteredMapParams{}); // 1024², as by default
    Image<float> ours, theirs(width, height);
    const auto look_up = [&] {
        frame.begin_technique();
        ours = for_each_receiver(frame, "look-up", [&](const Receiver& receiver, Pixel& pixel) {
            const MapPoint point = map_point(map, light, receiver, true);
            if (point.lit || point.dark) return point.lit ? 1.0f : 0.0f;
            return percentage_closer(map, point, kernel, vec2(0.5f * kernel), pixel.counters);
        });
    };
    const auto plain = [&] {
        parallel_for(height, 4, [&](size_t begin, size_t end) {
            for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y)
                for (int x = 0; x < width; ++x) {
                    const Receiver& receiver = frame.receivers()(x, y);
                    theirs(x, y) = 1.0f;
                    if (!receiver.valid()) continue;
                    const MapPoint point = map_point(map, light, receiver, true);
                    theirs(x, y) = point.dark ? 0.0f : plain_kernel(map, point);
                }
        });
    };
    bench.run(name, look_up, "plain loop over the map", plain);
    bench.agree(name, mean(ours), mean(theirs), 1e-6);
    const auto tests = static_cast<double>(frame.log().passes.back().texels_fetched);
    print_rate(bench, name, tests, "shadow tests");
}

// What revectorization adds to the shadow map that it starts from: `sm` and `rbsm-nonc` draw the same map, and both
// answer the same receivers.
void bench_revectorization(Bench& bench, const char* id) {
    const std::string name = fmt::format("{} dragon 2048 {}x{}", id, width, height);
    if (!bench.wanted(name)) return;
    const std::string path = GNOMON_SHARED "/scenes/dragon/dragon.glb";
    if (!std::filesystem::exists(path)) return;
    const Scene scene = load_scene(path);
    Frame frame(scene, scene.cameras.front(), width, height);
    const ParameterText parameters = {{"size", "2048"}};
    const auto run = [&](const char* technique) {
        const Entry& entry = find_technique(technique);
        frame.begin_technique();
        run_technique(entry, *entry.make(parameters), frame, scene.lights.front());
    };
    bench.run(
        name, [&] { run(id); }, "sm", [&] { run("sm"); });
}

} // namespace

void bench_passes(Bench& bench) {
    bench_distance_transform(bench);
    bench_summed_area<std::int64_t>(bench, "int64");
    bench_summed_area<double>(bench, "double");
    bench_summed_area<float>(bench, "float");
    bench_summed_area<std::int64_t, 4>(bench, "int64 rgba");
    bench_summed_area<std::uint32_t, 4>(bench, "uint32 rgba");
    bench_summed_area<double, 4>(bench, "double rgba");
    bench_summed_area<float, 4>(bench, "float rgba");
    bench_percentage_closer(bench);
    for (const char* id : {"rbsm-cons", "rbsm-nonc", "rbsm-filt"}) bench_revectorization(bench, id);
}

} // namespace gnomon_bench
