#include "eval/report/report.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include <fmt/format.h>

#include "core/atomic_file.h"
#include "core/error.h"
#include "core/image_file.h"
#include "core/parallel.h"
#include "eval/color_map.h"
#include "eval/metrics.h"
#include "eval/report/template.h"

namespace gnomon {
namespace {

using Json = nlohmann::ordered_json;

std::string base64(const std::string& bytes) {
    constexpr char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    for (size_t i = 0; i < bytes.size(); i += 3) {
        unsigned group = 0;
        for (size_t j = 0; j < 3; ++j)
            group = group << 8 | (i + j < bytes.size() ? static_cast<unsigned char>(bytes[i + j]) : 0u);
        for (size_t j = 0; j < 4; ++j) text += i + j <= bytes.size() ? letters[group >> (18 - 6 * j) & 63] : '=';
    }
    return text;
}

// A browser decodes a PNG to 8 bits a channel, so 16 bits travel as two grey planes in one image: the high bytes on
// top, the low bytes below.
Image<std::uint8_t> split_planes(const Image<float>& visibility) {
    const int height = visibility.height();
    Image<std::uint8_t> planes(visibility.width(), 2 * height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < visibility.width(); ++x) {
            const float value = visibility(x, y);
            const auto code = static_cast<unsigned>(
                std::isfinite(value)
                    ? std::lround(std::clamp(value, 0.0f, 1.0f) * static_cast<float>(visibility_levels))
                    : visibility_levels + 1);
            planes(x, y + height) = static_cast<std::uint8_t>(code >> 8);
            planes(x, y) = static_cast<std::uint8_t>(code & 255);
        }
    return planes;
}

Image<std::uint8_t> black_and_white(const Image<std::uint8_t>& mask) {
    Image<std::uint8_t> image(mask.width(), mask.height());
    for (size_t i = 0; i < mask.size(); ++i) image.values()[i] = mask.values()[i] ? 255 : 0;
    return image;
}

Json metric_values(const std::vector<std::pair<std::string, double>>& values) {
    Json json = Json::object();
    for (const auto& [id, value] : values)
        if (!std::isnan(value)) json[id] = std::isfinite(value) ? Json(value) : Json("infinite");
    return json;
}

Json entry_json(const ReportEntry& entry) {
    return {
        {"id", entry.id},
        {"title", entry.title},
        {"kind", entry.kind},
        {"paper", entry.paper},
        {"parameters", entry.parameters},
        {"passes", entry.passes},
        {"seconds", entry.seconds},
        {"peak_bytes", entry.peak_bytes},
        {"links", entry.links},
        {"metrics",
         {{"visibility", metric_values(entry.visibility_metrics)}, {"shaded", metric_values(entry.shaded_metrics)}}},
        {"shaded", entry.shaded.empty() ? "" : base64(encode_png(entry.shaded))},
        {"visibility", entry.visibility.empty() ? "" : base64(encode_png(split_planes(entry.visibility)))}};
}

// The metrics that some entry has, in the order in which they are listed everywhere.
Json metric_table(const ReportData& data) {
    const auto has = [](const std::vector<std::pair<std::string, double>>& values, const std::string& id) {
        return std::any_of(values.begin(), values.end(), [&](const auto& value) { return value.first == id; });
    };
    Json rows = Json::array();
    for (const Metric& metric : metrics())
        if (std::any_of(data.entries.begin(), data.entries.end(), [&](const ReportEntry& entry) {
                return has(entry.visibility_metrics, metric.id) || has(entry.shaded_metrics, metric.id);
            }))
            rows.push_back({{"id", metric.id},
                            {"title", metric.title},
                            {"formula", metric.formula},
                            {"range", metric.range},
                            {"blind_to", metric.blind_to},
                            {"lower_is_better", metric.lower_is_better}});
    return rows;
}

// The size of all images in the report; throws where they differ.
std::pair<int, int> common_size(const ReportData& data) {
    std::pair<int, int> size{0, 0};
    const auto check = [&](const auto& image, const std::string& what) {
        if (image.empty()) return;
        const std::pair<int, int> own{image.width(), image.height()};
        if (size.first == 0) size = own;
        if (own != size)
            throw UsageError(fmt::format("a report shows images of one size, but {} is {}x{} beside {}x{}", what,
                                         own.first, own.second, size.first, size.second));
    };
    for (const ReportEntry& entry : data.entries) {
        check(entry.shaded, fmt::format("the shaded image of '{}'", entry.id));
        check(entry.visibility, fmt::format("the visibility of '{}'", entry.id));
    }
    check(data.mask, "the mask");
    return size;
}

int reference_index(const ReportData& data) {
    if (data.reference_id.empty()) return -1;
    for (size_t i = 0; i < data.entries.size(); ++i)
        if (data.entries[i].id == data.reference_id) return static_cast<int>(i);
    throw UsageError(fmt::format("the report's reference '{}' is not among its entries", data.reference_id));
}

Json report_json(const ReportData& data) {
    const auto [width, height] = common_size(data);
    const int reference = reference_index(data);
    std::vector<Json> entries(data.entries.size()); // compressed in parallel
    parallel_for(entries.size(), 1, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) entries[i] = entry_json(data.entries[i]);
    });
    return {{"title", data.title},
            {"scene", data.scene},
            {"camera", data.camera},
            {"light", data.light},
            {"command_lines", data.command_lines},
            {"width", width},
            {"height", height},
            {"reference", reference},
            {"visibility_levels", visibility_levels},
            {"color_maps", {{"signed", blue_white_red()}, {"magnitude", magma()}}},
            {"metrics", metric_table(data)},
            {"mask", data.mask.empty() ? "" : base64(encode_png(black_and_white(data.mask)))},
            {"entries", std::move(entries)}};
}

void replace_once(std::string& text, std::string_view mark, std::string_view replacement) {
    const size_t at = text.find(mark);
    assert(at != std::string::npos);
    text.replace(at, mark.size(), replacement);
}

std::string escape_html(const std::string& text) {
    std::string escaped;
    for (const char letter : text) {
        if (letter == '&')
            escaped += "&amp;";
        else if (letter == '<')
            escaped += "&lt;";
        else if (letter == '>')
            escaped += "&gt;";
        else
            escaped += letter;
    }
    return escaped;
}

// JSON inside a script element: no text in it can end the element.
std::string script_safe(const Json& json) {
    std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
    std::string safe;
    safe.reserve(text.size());
    for (const char letter : text) {
        if (letter == '<')
            safe += "\\u003c";
        else
            safe += letter;
    }
    return safe;
}

} // namespace

std::string report_page(const ReportData& data) {
    std::string page(report_html);
    replace_once(page, "{{style}}", report_style);
    replace_once(page, "{{script}}", report_script);
    replace_once(page, "{{data}}", script_safe(report_json(data)));
    replace_once(page, "{{title}}",
                 escape_html(data.title)); // its mark is the page's first: no text can stand in for it
    return page;
}

void write_report(const std::string& path, const ReportData& data) { write_text_file(path, report_page(data)); }

} // namespace gnomon
