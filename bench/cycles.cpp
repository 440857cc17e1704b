// The truth beside Blender's Cycles: the same triangles, camera and square light, 512² pixels of 1024 samples, from the
// triangles to the image, so that both sides build their trees. Ours traces every ray.
//
// Cycles gives radiance, and of a whole pixel: its 1024 samples are spread over the pixel (box filter) and over the
// solid angle of the light. Ours are spread over the light's area, from the pixel's centre. So each is held to a
// reference of its own quantity, radiance as a fraction of what the unshadowed light would send: ours to the pixel's
// centre, theirs to the mean of 4 × 4 points of the pixel, both with 65536 samples. The reference is itself held to the
// exact visibility. Pixels are those of the penumbra that show one plane, with what is around them: edges of geometry
// are a matter of anti-aliasing.

#include <cmath>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>

#include "bench/bench.h"
#include "bench/command.h"
#include "bench/scenes.h"
#include "core/image_file.h"
#include "core/parallel.h"
#include "raytrace/exact.h"
#include "raytrace/truth.h"
#include "techniques/frame.h"

namespace gnomon_bench {
namespace {

constexpr const char* script = GNOMON_SHARED "/peers/blender_gt.py";
constexpr int side = 512, samples = 1024, rounds = 5;
constexpr int points_across = 4;               // of a pixel
constexpr int reference_samples = 65536;       // of a pixel
constexpr size_t most_pixels = 4000;           // looked at
constexpr double albedo = 0.8, power = 1000.0; // of the script

Scene lit_scene(bool big) {
    Scene scene = spheres(big);
    Light light = rectangle({4, 11, 3}, {0, 1, 0}, 2.0f);
    light.tangent = glm::normalize(glm::cross(light.direction, vec3(0, 1, 0))); // a square has a side that lies level
    scene.lights = {light};
    return scene;
}

// What the script reads: numbers of vertices and triangles, positions, normals, indices.
void write_triangles(const std::string& path, const Scene& scene) {
    std::ofstream file(path, std::ios::binary);
    const auto write = [&](const auto& values) {
        file.write(reinterpret_cast<const char*>(values.data()),
                   static_cast<std::streamsize>(values.size() * sizeof(values[0])));
    };
    write(std::array{static_cast<std::uint32_t>(scene.positions.size()),
                     static_cast<std::uint32_t>(scene.triangles.size())});
    write(scene.positions), write(scene.positions), write(scene.triangles); // it reads the normals, and uses none
    if (!file.flush()) throw std::runtime_error(fmt::format("{} cannot be written", path));
}

struct Rendered {
    Image<float> image; // as Cycles has it
    double ms;
};

// In an environment of its own: Blender finds settings and libraries by variables.
Rendered render_with_cycles(const Scene& scene) {
    const TemporaryFolder folder;
    const std::string triangles = folder.file("scene.bin"), image = folder.file("cycles.exr");
    write_triangles(triangles, scene);
    const Output output = run({"env", "-i", "PATH=/usr/local/bin:/usr/bin:/bin", "HOME=" + folder.path(), "blender",
                               "-b", "--factory-startup", "-t", std::to_string(threads), "-P", script, "--", triangles,
                               std::to_string(side), std::to_string(side), std::to_string(samples), image});
    const double seconds = number_after(output.text, fmt::format("CSV,scene.bin,{}x{},{},", side, side, samples));
    const ChannelImage read = read_image(image);
    const Channel* red = read.find("R");
    if (!red) throw std::runtime_error("Cycles has written no colour");
    return {red->values, 1e3 * seconds};
}

// Radiance that a white surface sends, divided by what it would send unshadowed: visibility weighted by the cosines and
// the distance. Also the plain one.
struct Fractions {
    Image<float> weighted, visibility;
};

Fractions fractions(const EmbreeScene& rays, const Receivers& receivers, const Light& light, int count,
                    std::uint32_t seed, const TriangleClusters* clusters) {
    TruthSettings settings;
    settings.samples = count;
    settings.seed = seed;
    settings.surface = [&](int x, int y) {
        const Receiver& r = receivers(x, y);
        return Surface{.position = r.position, .normal = r.geometric_normal, .albedo = vec3(1.0f)};
    };
    TruthRun run;
    run.clusters = clusters;
    TruthAnswer answer = area_truth(rays, receivers, light, settings, run);
    Fractions result{Image<float>(receivers.width(), receivers.height(), 1.0f), std::move(answer.visibility)};
    for (size_t i = 0; i < receivers.size(); ++i) {
        const Receiver& r = receivers.values()[i];
        const float unshadowed = unshadowed_irradiance(light, r.position, r.geometric_normal).x;
        if (r.valid() && unshadowed > 0)
            result.weighted.values()[i] = static_cast<float>(pi) * answer.radiance->values()[i].x / unshadowed;
    }
    return result;
}

bool on_plane(const Receiver& plane, const Receiver& r) {
    constexpr float flat = 1e-4f; // of the normal, and metres
    return r.valid() && glm::distance(plane.geometric_normal, r.geometric_normal) < flat &&
           std::abs(glm::dot(plane.geometric_normal, r.position - plane.position)) < flat;
}

// The pixel's points and those next to it lie on the plane of its centre.
bool shows_one_plane(const Receiver& center, const Receivers& fine, ivec2 pixel) {
    if (!center.valid()) return false;
    for (int y = -1; y <= points_across; ++y)
        for (int x = -1; x <= points_across; ++x)
            if (!on_plane(center, fine(points_across * pixel.x + x, points_across * pixel.y + y))) return false;
    return true;
}

// Up to `most_pixels`, evenly spread over those that show one plane and face the light.
std::vector<ivec2> chosen_pixels(const Receivers& receivers, const Receivers& fine, const Light& light) {
    std::vector<ivec2> all, chosen;
    for (int y = 1; y + 1 < side; ++y)
        for (int x = 1; x + 1 < side; ++x)
            if (const Receiver& r = receivers(x, y);
                r.valid() && faces_light(r, light) && shows_one_plane(r, fine, {x, y}))
                all.push_back({x, y});
    const size_t count = std::min(most_pixels, all.size());
    for (size_t i = 0; i < count; ++i) chosen.push_back(all[i * all.size() / count]);
    return chosen;
}

double root_mean_square(const std::vector<double>& differences) {
    double sum = 0;
    for (const double d : differences) sum += d * d;
    return std::sqrt(sum / static_cast<double>(differences.size()));
}

// The scale between Cycles' image and fractions: to Blender, a light of power P and area A has the radiance P / (4 A).
double cycles_fraction(float value, const Receiver& receiver, const Light& light) {
    const double irradiance =
        static_cast<double>(unshadowed_irradiance(light, receiver.position, receiver.geometric_normal).x);
    const double radiance = power / (4 * static_cast<double>(surface_area(light)));
    return static_cast<double>(value) / (albedo / pi * irradiance * radiance);
}

void compare_errors(Bench& bench, const std::string& name, const Scene& scene, const Image<float>& cycles) {
    const Light& light = scene.lights.front();
    Frame frame(scene, scene.cameras.front(), side, side);
    Frame fine(scene, scene.cameras.front(), points_across * side, points_across * side);
    const std::vector<ivec2> pixels = chosen_pixels(frame.receivers(), fine.receivers(), light);
    constexpr int points = points_across * points_across;
    const auto count = static_cast<int>(pixels.size());
    Receivers centers(1, count), footprints(points, count);
    for (int i = 0; i < count; ++i) {
        const ivec2 pixel = pixels[static_cast<size_t>(i)];
        centers(0, i) = frame.receivers()(pixel.x, pixel.y);
        for (int k = 0; k < points; ++k)
            footprints(k, i) = fine.receivers()(points_across * pixel.x + k % points_across,
                                                points_across * pixel.y + k / points_across);
    }
    const TriangleClusters& clusters = frame.clusters();
    const Fractions ours = fractions(frame.rays(), centers, light, samples, 0, nullptr),
                    reference = fractions(frame.rays(), centers, light, reference_samples, 1, &clusters),
                    reference_points =
                        fractions(frame.rays(), footprints, light, reference_samples / points, 1, &clusters);
    std::vector<double> ours_error, cycles_error, ours_from_exact, reference_from_exact, lit;
    for (int i = 0; i < count; ++i) {
        const auto at = [i](const Image<float>& image) { return static_cast<double>(image(0, i)); };
        double footprint = 0;
        for (int k = 0; k < points; ++k) footprint += static_cast<double>(reference_points.weighted(k, i)) / points;
        const ivec2 pixel = pixels[static_cast<size_t>(i)];
        const double theirs = cycles_fraction(cycles(pixel.x, pixel.y), centers(0, i), light);
        if (at(reference.visibility) == 1.0) lit.push_back(theirs - footprint);
        if (at(reference.visibility) == 0.0 || at(reference.visibility) == 1.0) continue;
        const double exact = exact_visibility(scene, clusters, centers(0, i), light);
        ours_error.push_back(at(ours.weighted) - at(reference.weighted));
        cycles_error.push_back(theirs - footprint);
        ours_from_exact.push_back(at(ours.visibility) - exact);
        reference_from_exact.push_back(at(reference.visibility) - exact);
    }
    const double our_error = root_mean_square(ours_error), their_error = root_mean_square(cycles_error);
    fmt::print(
        stderr,
        "{}: root mean square error of radiance on {} pixels of the penumbra, unshadowed = 1: ours {:.5f}, Cycles "
        "{:.5f} ({:.5f} where all of the light is seen); of visibility, from the exact one: ours {:.5f}, the "
        "reference {:.6f}\n",
        name, ours_error.size(), our_error, their_error, root_mean_square(lit), root_mean_square(ours_from_exact),
        root_mean_square(reference_from_exact));
    bench.require(our_error <= their_error, name, "our error is larger than that of Cycles");
}

void bench_scene(Bench& bench, bool big) {
    const std::string name = fmt::format("truth cycles {} {}x{}", big ? "big" : "small", side, side);
    if (!bench.asked_for(name, "cycles")) return;
    if (!is_installed("blender") || !std::filesystem::exists(script)) {
        fmt::print(stderr, "gnomon-bench: {} is left out: it needs blender (bin/setup cycles) and {}\n", name, script);
        return;
    }
    const Scene scene = lit_scene(big);
    const Rendered cycles = render_with_cycles(scene);
    std::vector<double> ours_ms;
    with_threads(threads, [&] {
        for (int i = 0; i < rounds; ++i)
            ours_ms.push_back(milliseconds([&] {
                Frame frame(scene, scene.cameras.front(), side, side);
                area_visibility(frame.rays(), frame.receivers(), scene.lights.front(), Pattern::Sobol, samples, 0,
                                nullptr);
            }));
    });
    bench.record({name, "Cycles", median(ours_ms), cycles.ms});
    compare_errors(bench, name, scene, cycles.image);
}

} // namespace

void bench_cycles(Bench& bench) {
    for (const bool big : {false, true}) bench_scene(bench, big);
}

} // namespace gnomon_bench
