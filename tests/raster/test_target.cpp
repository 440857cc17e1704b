#include <catch2/catch.hpp>

#include "core/error.h"
#include "raster/full_screen.h"
#include "raster/target.h"

using namespace gnomon;

TEST_CASE("mip levels halve down to one texel, and no further") {
    CHECK(full_level_count(1, 1) == 1);
    CHECK(full_level_count(256, 256) == 9);
    CHECK(full_level_count(5, 12) == 4);
    const Target target(Format::R32F, 5, 12, 1, nullptr, 4);
    CHECK(target.levels() == 4);
    CHECK(target.width() == 5);
    CHECK(target.width(1) == 2);
    CHECK(target.width(3) == 1);
    CHECK(target.height(2) == 3);
    CHECK(target.height(3) == 1);
    CHECK(target.bytes() == 4 * (5 * 12 + 2 * 6 + 1 * 3 + 1 * 1));
    CHECK_THROWS_AS(Target(Format::R32F, 5, 12, 1, nullptr, 5), UsageError);
    CHECK_THROWS_AS(Target(Format::R32F, 5, 12, 1, nullptr, 0), UsageError);
    CHECK_THROWS_AS(Target(Format::R32F, 5, 12, 0), UsageError);
}

TEST_CASE("level 0 is laid out as a target without levels, and each level follows the one before") {
    Target target(Format::R32F, 8, 4, 3, nullptr, 4);
    const std::byte* first = target.texel(0, 0, 0);
    CHECK(target.texel(3, 2, 1) - first == 4 * ((1 * 4 + 2) * 8 + 3));
    CHECK(target.texel(0, 0, 0, 1) - first == 4 * 3 * 8 * 4);
    CHECK(target.texel(1, 1, 2, 1) - first == 4 * (3 * 8 * 4 + (2 * 2 + 1) * 4 + 1));
    CHECK(target.texel(0, 0, 2, 3) - first == target.bytes() - 4);
    CHECK(reinterpret_cast<const std::byte*>(target.row<float>(1, 2, 1)) == target.texel(0, 1, 2, 1));
}

TEST_CASE("every texel of every layer and level is its own") {
    const Format format = GENERATE(Format::R32F, Format::RGBA8, Format::RG16F, Format::D16, Format::D24, Format::D32F,
                                   Format::S8, Format::R32UI, Format::RGBA16UI);
    Target target(format, 7, 4, 6, nullptr, 3);
    const FormatInfo& f = info(format);
    const bool keys = f.kind == FormatInfo::Kind::Depth || f.kind == FormatInfo::Kind::Stencil;
    const auto each = [&](const auto& visit) {
        std::uint32_t n = 0;
        for (int level = 0; level < 3; ++level)
            for (int layer = 0; layer < 6; ++layer)
                for (int y = 0; y < target.height(level); ++y)
                    for (int x = 0; x < target.width(level); ++x) visit(x, y, layer, level, ++n % 251);
    };
    each([&](int x, int y, int layer, int level, std::uint32_t n) {
        if (keys)
            target.store_key(x, y, layer, n, level);
        else if (f.kind == FormatInfo::Kind::Uint)
            target.store_uint(x, y, layer, glm::uvec4(n), 15, level);
        else
            target.store(x, y, layer, vec4(static_cast<float>(n) / 255.0f), 15, level);
    });
    int wrong = 0;
    each([&](int x, int y, int layer, int level, std::uint32_t n) {
        const float value = static_cast<float>(n) / 255.0f;
        if (keys)
            wrong += target.load_key(x, y, layer, level) != n ||
                     (f.kind == FormatInfo::Kind::Depth &&
                      (target.depth(x, y, layer, level) != depth_from_key(format, n) ||
                       target.load(x, y, layer, level) != vec4(depth_from_key(format, n), 0, 0, 1)));
        else if (f.kind == FormatInfo::Kind::Uint)
            wrong += target.load_uint(x, y, layer, level).x != n;
        else
            wrong += std::abs(target.load(x, y, layer, level).x - value) > 1e-3f;
    });
    CHECK(wrong == 0);
}

TEST_CASE("a full-screen pass writes one layer of one level") {
    PassLog log;
    Pass pass(log, "level");
    Target target(Format::R32F, 8, 6, 2, nullptr, 3);
    full_screen(pass, Targets{.color = {&target}, .layer = 1, .level = 1},
                [](Pixel& p) { p.color[0].x = static_cast<float>(10 * p.y + p.x + 1); });
    CHECK(log.passes[0].fragments_shaded == 4 * 3);
    CHECK(target.load(3, 2, 1, 1).x == 24.0f);
    CHECK(target.load(0, 0, 1, 1).x == 1.0f);
    int others = 0;
    for (int level = 0; level < 3; ++level)
        for (int layer = 0; layer < 2; ++layer)
            for (int y = 0; y < target.height(level); ++y)
                for (int x = 0; x < target.width(level); ++x)
                    others += target.load(x, y, layer, level).x != 0.0f && (layer != 1 || level != 1);
    CHECK(others == 0);
}

TEST_CASE("a clear reaches every layer and level, and counts them") {
    PassLog log;
    Pass pass(log, "clear");
    Target target(Format::D24, 4, 4, 2, nullptr, 3);
    target.clear_depth(pass, 1.0f);
    CHECK(log.passes[0].bytes_written == target.bytes());
    CHECK(target.depth(3, 3, 1, 0) == 1.0f);
    CHECK(target.depth(1, 1, 1, 1) == 1.0f);
    CHECK(target.depth(0, 0, 1, 2) == 1.0f);
}
