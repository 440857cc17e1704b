#include "bin/bounds.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "bin/text.h"
#include "core/atomic_file.h"
#include "core/error.h"
#include "core/json_reader.h"

namespace gnomon {
namespace {

constexpr const char* missing = "missing"; // the count that may have a bound as well
constexpr double largest_bound = 1e30;

std::string suggestion(const std::string& id) {
    std::vector<std::string> names = {missing};
    for (const Metric& metric : metrics()) names.push_back(metric.id);
    return did_you_mean(id, names);
}

bool can_have_bound(const std::string& id) { return id == missing || find_metric(id); }

double value_of(const Comparison& comparison, const std::string& id) {
    if (id == missing) return static_cast<double>(comparison.missing);
    for (const auto& [name, value] : comparison.metrics)
        if (name == id) return value;
    throw InputError(fmt::format("the bound on '{}' cannot be tested: it does not apply to '{}' and '{}'", id,
                                 comparison.test, comparison.reference));
}

} // namespace

void check_metric(const std::string& id) {
    if (id != "all" && !find_metric(id))
        throw UsageError(fmt::format("there is no metric '{}'{} (gnomon list metrics shows them)", id, suggestion(id)));
}

std::string value_text(double value) { return std::isfinite(value) ? fmt::format("{:.6g}", value) : "infinite"; }

void read_bounds(const std::vector<std::string>& texts, bool above, std::vector<Bound>& bounds) {
    const std::string option = above ? "--fail-above" : "--fail-below";
    for (const std::string& text : texts) {
        const size_t equals = text.find('=');
        if (equals == std::string::npos)
            throw UsageError(fmt::format("{} is '{}', but must be METRIC=NUMBER, such as rmse=0.05", option, text));
        const std::string metric = text.substr(0, equals);
        if (!can_have_bound(metric)) check_metric(metric == "all" ? "'all'" : metric);
        bounds.push_back(
            {metric, parse_real(text.substr(equals + 1), option + " " + metric, -largest_bound, largest_bound), above});
    }
}

void read_bounds_file(const std::string& path, std::vector<Bound>& bounds) {
    const nlohmann::json document = parse_json(read_file(path), path);
    const JsonReader reader(document, path);
    reader.expect_object();
    reader.only({"fail_above", "fail_below"});
    for (const bool above : {true, false}) {
        const std::string key = above ? "fail_above" : "fail_below";
        if (!reader.has(key)) continue;
        const JsonReader list = reader.at(key);
        list.expect_object();
        for (const auto& [metric, value] : list.value().items()) {
            if (!can_have_bound(metric))
                list.fail(fmt::format("names '{}', which is no metric{}", one_line(metric), suggestion(metric)));
            bounds.push_back({metric, list.at(metric).number(-largest_bound, largest_bound), above});
        }
    }
}

void check_bounds(const Comparison& comparison, const std::vector<Bound>& bounds) {
    std::string crossed;
    for (const Bound& bound : bounds) {
        const double value = value_of(comparison, bound.metric);
        if (bound.above ? value > bound.value : value < bound.value)
            crossed += fmt::format("{}{} is {}, {} the bound {}", crossed.empty() ? "" : "; ", bound.metric,
                                   value_text(value), bound.above ? "above" : "below", bound.value);
    }
    if (!crossed.empty()) throw Error(ExitCode::BoundCrossed, crossed);
}

} // namespace gnomon
