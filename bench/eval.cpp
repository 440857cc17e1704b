// gnomon compare beside what people otherwise compare images with: whole commands, from files to printed numbers.

#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "bench/bench.h"
#include "bench/command.h"
#include "core/image_file.h"

namespace gnomon_bench {
namespace {

using namespace gnomon;

constexpr int width = 3840, height = 2160;

// A floor with wavy soft shadows, `widening` times as wide as the truth's, and grain.
Image<float> shadows(float widening) {
    Image<float> image(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const float u = static_cast<float>(x), v = static_cast<float>(y);
            const float edge = 60.0f * std::sin(0.011f * v) + 90.0f * std::sin(0.017f * u + 0.003f * v);
            image(x, y) = std::clamp(0.5f + edge / (60.0f * widening), 0.0f, 1.0f);
        }
    return image;
}

// Scene-linear, in [0, 1]: ImageMagick clamps what is above.
Image<vec3> colors(const Image<float>& visibility) {
    Image<vec3> image(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const float grain = 0.1f * std::sin(1.3f * static_cast<float>(x) + 2.1f * static_cast<float>(y));
            image(x, y) = vec3(0.55f, 0.5f, 0.4f) * (0.08f + 0.9f * visibility(x, y)) * (1.0f + grain);
        }
    return image;
}

struct Files {
    TemporaryFolder folder;
    std::string color_test, color_reference, visibility_test, visibility_reference;

    Files() {
        const auto write = [&](const char* name, float widening, std::string& color, std::string& visibility) {
            const Image<float> values = shadows(widening);
            ChannelImage picture, channel;
            picture.add_color("", colors(values), false);
            channel.add("V", values);
            write_exr(color = folder.file(fmt::format("{}-color.exr", name)), picture);
            write_exr(visibility = folder.file(fmt::format("{}-visibility.exr", name)), channel);
        };
        write("test", 1.3f, color_test, visibility_test);
        write("reference", 1.0f, color_reference, visibility_reference);
    }
};

Output ours(const std::string& test, const std::string& reference, const std::string& metrics) {
    return run({GNOMON_PROGRAM, "compare", test, reference, "--metrics", metrics, "--json", "-", "--threads",
                std::to_string(threads)});
}

// One comparison by both; the RMSE that they find must agree.
struct Duel {
    const char* name;
    bool of_color;
    const char* metrics; // of ours
    const char* peer;
    const char* words; // before the peer's RMSE
    double tolerance;

    std::string benchmark() const { return fmt::format("eval {} {}x{}", name, width, height); }
};
constexpr const char* image_magick = "compare -metric RMSE";
constexpr const char* rms_error = "RMS error = ";
constexpr Duel duels[] = {
    {"rmse", true, "rmse", image_magick, "(", 1e-3}, // it rounds to 16 bits
    {"mae,rmse,psnr,max", true, "mae,rmse,psnr,max", "oiiotool --diff", rms_error, 1e-4},
    {"all metrics of a colour", true, "all", "oiiotool --diff (four)", rms_error, 1e-4},
    {"all metrics of visibility", false, "all", "oiiotool --diff (four)", rms_error, 1e-4},
};

std::vector<std::string> peer_command(const Duel& duel, const std::string& test, const std::string& reference) {
    if (duel.peer == image_magick) return {"compare", "-metric", "RMSE", test, reference, "null:"};
    return {"oiiotool", "--threads", std::to_string(threads), test, reference, "--diff"};
}

void fight(Bench& bench, const Duel& duel, const std::string& test, const std::string& reference) {
    const std::string benchmark = duel.benchmark();
    const std::vector<std::string> command = peer_command(duel, test, reference);
    if (!is_installed(command[0])) {
        fmt::print(stderr, "gnomon-bench: {} is left out: {} is not installed\n", benchmark, command[0]);
        return;
    }
    Output mine, theirs;
    bench.run(
        benchmark, [&] { mine = ours(test, reference, duel.metrics); }, duel.peer,
        [&] { theirs = run(command, 2); }); // 1, 2: the images differ
    bench.agree(benchmark, number_after(mine.text, "\"rmse\":"), number_after(theirs.text, duel.words), duel.tolerance);
    fmt::print(stderr, "{}: at most {:.0f} MiB resident, the peer {:.0f}\n", benchmark, mine.peak_mib, theirs.peak_mib);
}

} // namespace

void bench_eval(Bench& bench) {
    std::optional<Files> files; // written for those that are wanted
    for (const Duel& duel : duels) {
        if (!bench.wanted(duel.benchmark())) continue;
        if (!files) files.emplace();
        fight(bench, duel, duel.of_color ? files->color_test : files->visibility_test,
              duel.of_color ? files->color_reference : files->visibility_reference);
    }
}

} // namespace gnomon_bench
