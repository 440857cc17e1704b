#include <catch2/catch.hpp>

#include <cmath>

#include "core/error.h"
#include "eval/sequence.h"
#include "tests/eval/channels.h"

using namespace gnomon;

namespace {

constexpr int width = 64, height = 8;

ChannelImage image_of(const std::function<float(int x)>& visibility) {
    Image<float> values(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) values(x, y) = visibility(x);
    ChannelImage image;
    image.add("V", values);
    return image;
}

// A camera that has moved right by `offset` pixels over a plane; receivers lie at pixel centres.
void add_receivers(ChannelImage& image, int offset) {
    Image<vec3> positions(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            positions(x, y) = {static_cast<float>(x + offset) + 0.5f, static_cast<float>(y) + 0.5f, 0.0f};
    image.add_vector("P", positions);
    mat4 matrix(1.0f);
    matrix[0][0] = 2.0f / width, matrix[1][1] = 2.0f / height;
    matrix[3] = vec4(-1.0f - 2.0f * static_cast<float>(offset) / width, -1.0f, 0.0f, 1.0f);
    image.attributes["worldToNDC"] = matrix;
}

double value_of(const SequenceComparison& sequence, const std::string& id) {
    return gnomon_tests::value_of(sequence.whole, id);
}

SequenceComparison compared(const std::vector<std::pair<ChannelImage, ChannelImage>>& frames) {
    SequenceComparer comparer({});
    for (size_t i = 0; i < frames.size(); ++i)
        comparer.add(std::to_string(i), "test", frames[i].first, "reference", frames[i].second);
    return comparer.finish();
}

const ChannelImage half = image_of([](int) { return 0.5f; });

ChannelImage off_by(float error) {
    return image_of([&](int) { return 0.5f + error; });
}

} // namespace

TEST_CASE("an error that stays is stable, one that changes sign is not") {
    const SequenceComparison steady = compared({{off_by(0.25f), half}, {off_by(0.25f), half}, {off_by(0.25f), half}});
    CHECK(value_of(steady, "temporal_mean") == 0.0);
    CHECK(value_of(steady, "temporal_rms") == 0.0);
    CHECK(value_of(steady, "mae") == 0.25);
    const SequenceComparison flickering =
        compared({{off_by(0.25f), half}, {off_by(-0.25f), half}, {off_by(0.25f), half}});
    CHECK(value_of(flickering, "temporal_mean") == 0.5);
    CHECK(value_of(flickering, "temporal_rms") == 0.5);
    CHECK(value_of(flickering, "mae") == 0.25); // which does not see it
    // One change of 1/2, then none.
    const SequenceComparison once = compared({{off_by(-0.25f), half}, {off_by(0.25f), half}, {off_by(0.25f), half}});
    CHECK(value_of(once, "temporal_mean") == 0.25);
    CHECK(value_of(once, "temporal_rms") == Approx(std::sqrt(0.125)));
}

TEST_CASE("a moving shadow that is drawn right is stable") {
    std::vector<std::pair<ChannelImage, ChannelImage>> frames;
    for (int frame = 0; frame < 4; ++frame) {
        const ChannelImage image = image_of([&](int x) { return x < 20 + 3 * frame ? 0.0f : 1.0f; });
        frames.emplace_back(image, image);
    }
    CHECK(value_of(compared(frames), "temporal_mean") == 0.0);
    CHECK(std::isnan(value_of(compared({frames[0]}), "temporal_mean")));
}

TEST_CASE("with a moving camera, receivers are followed") {
    // An error that belongs to the receiver at x = 30 of the plane, and a camera that moves two pixels a frame.
    const auto frames = [](bool follows, bool with_receivers) {
        std::vector<std::pair<ChannelImage, ChannelImage>> list;
        for (int frame = 0; frame < 3; ++frame) {
            const int offset = 2 * frame;
            ChannelImage test = image_of([&](int x) { return x + (follows ? offset : 0) == 30 ? 1.0f : 0.5f; });
            ChannelImage reference = half;
            if (with_receivers) add_receivers(reference, offset);
            list.emplace_back(std::move(test), std::move(reference));
        }
        return list;
    };
    CHECK(value_of(compared(frames(true, true)), "temporal_mean") == 0.0);
    // An error that sticks to the screen: two of the 62 receivers that two frames share change by 1/2.
    CHECK(value_of(compared(frames(false, true)), "temporal_mean") == Approx(2 * 0.5 / 62));
    // Without positions, pixels are taken for receivers, and the verdicts are turned round.
    CHECK(value_of(compared(frames(true, false)), "temporal_mean") == Approx(2 * 0.5 / 64));
    CHECK(value_of(compared(frames(false, false)), "temporal_mean") == 0.0);
}

TEST_CASE("a receiver that was hidden one frame before has no say") {
    ChannelImage before = half, now = half;
    add_receivers(before, 0);
    add_receivers(now, 0);
    for (const char* name : {"P.X", "P.Y", "P.Z"}) // something stood in front of half the picture
        for (Channel& channel : before.channels)
            if (channel.name == name)
                for (int y = 0; y < height; ++y)
                    for (int x = 32; x < width; ++x) channel.values(x, y) += 100.0f;
    ChannelImage test_before = half, test_now = half;
    for (int y = 0; y < height; ++y)
        for (int x = 32; x < width; ++x) test_now.channels[0].values(x, y) = 1.0f;
    CHECK(value_of(compared({{test_before, before}, {test_now, now}}), "temporal_mean") == 0.0);
}

TEST_CASE("a sequence's counts are sums and its JSON has every frame") {
    ChannelImage spoilt = off_by(0.1f);
    spoilt.channels[0].values(3, 3) = std::nanf("");
    const SequenceComparison sequence = compared({{off_by(0.0f), half}, {spoilt, half}});
    CHECK(sequence.whole.pixels == 2 * width * height);
    CHECK(sequence.whole.missing == 1);
    CHECK(sequence.whole.masked == 2 * width * height - 1);
    const nlohmann::ordered_json json = sequence_json(sequence);
    REQUIRE(json["frames"].size() == 2);
    CHECK(json["frames"][1]["frame"] == "1");
    CHECK(json["frames"][1]["missing"] == 1);
    CHECK(json["metrics"]["max"].get<double>() == Approx(0.1));
    CHECK(json["metrics"].contains("temporal_mean"));
    CHECK_FALSE(json["frames"][1]["metrics"].contains("temporal_mean"));
    CHECK(json.contains("confusion"));
}

TEST_CASE("frames that do not belong together are refused") {
    SequenceComparer comparer({});
    comparer.add("0", "a", half, "b", half);
    ChannelImage small;
    small.add("V", Image<float>(8, 8, 1.0f));
    CHECK_THROWS_AS(comparer.add("1", "c", small, "d", small), InputError);
    ChannelImage other;
    other.add("Y", Image<float>(width, height, 1.0f));
    CHECK_THROWS_AS(comparer.add("1", "c", other, "d", other), InputError);
}
