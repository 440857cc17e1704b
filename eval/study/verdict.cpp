#include "eval/study/verdict.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <set>

#include <fmt/format.h>

#include "eval/study/pivot.h"

namespace gnomon {
namespace {

using nlohmann::ordered_json;

constexpr size_t most_listed = 4; // groups that are told one by one

std::string selection_text(const StudySelection& selection, const StudyLabels& labels) {
    std::string text;
    for (const auto& [key, choice] : selection) {
        std::vector<std::string> words;
        for (const std::string& one : choice) words.push_back(label_of(labels, key, one));
        text += fmt::format("{}{} {}", text.empty() ? "" : ", ", key_title(key), fmt::join(words, "/"));
    }
    return text;
}

std::string side_text(const ClaimSide& side, const StudySelection& where, const StudyLabels& labels) {
    const std::string of = selection_text(where, labels);
    const std::string how = !side.power_key.empty()    ? "exponent over " + key_title(side.power_key) + " of "
                            : side.aggregate == "mean" ? ""
                                                       : side.aggregate + " of ";
    return how + side.value.text() + (of.empty() ? "" : " of [" + of + "]");
}

// What the right side chooses otherwise than the left.
StudySelection difference(const StudySelection& right, const StudySelection& left) {
    StudySelection rest;
    for (const auto& [key, choice] : right)
        if (const auto found = left.find(key); found == left.end() || found->second != choice) rest[key] = choice;
    return rest;
}

std::string formula_of(const ClaimCheck& check, const StudyLabels& labels) {
    std::string text = side_text(check.left, check.left.where, labels) + " " + check.relation + " ";
    if (check.right) {
        if (check.factor != 1) text += fmt::format("{:g} × ", check.factor);
        text += side_text(*check.right, difference(check.right->where, check.left.where), labels);
        if (check.offset != 0) text += fmt::format(" {} {:g}", check.offset < 0 ? '-' : '+', std::abs(check.offset));
    } else {
        text += fmt::format("{:g}", check.offset);
    }
    if (check.margin > 0) text += fmt::format(" ± {:g}", check.margin);
    std::vector<std::string> keys;
    for (const std::string& key : check.per) keys.push_back(key_title(key));
    if (!keys.empty()) text += fmt::format(", for each {}", fmt::join(keys, " and "));
    return text;
}

// The texts of the group's keys; "" where the record lacks one.
using GroupKey = std::vector<std::string>;

GroupKey group_of(const ClaimCheck& check, const StudyRecord& record) {
    GroupKey group;
    for (const std::string& key : check.per) {
        const auto found = record.keys.find(key);
        group.push_back(found == record.keys.end() ? "" : found->second);
    }
    return group;
}

// A row that lacks a key belongs to every group, and every row to the group that lacks it; of a key that `side` chooses
// for itself, every text does.
bool belongs(const ClaimCheck& check, const ClaimSide& side, const StudyRecord& record, const GroupKey& group) {
    const StudySelection own_choice = difference(side.where, check.left.where);
    const GroupKey own = group_of(check, record);
    for (size_t i = 0; i < group.size(); ++i)
        if (!own[i].empty() && !group[i].empty() && own[i] != group[i] && !own_choice.contains(check.per[i]))
            return false;
    return true;
}

// NaN where the text is no number.
double number_of(const std::string& text) {
    double number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    return error == std::errc() && end == text.data() + text.size() ? number : std::numeric_limits<double>::quiet_NaN();
}

struct SideValue {
    std::optional<double> value;
    size_t cells = 0;
    bool failed = false;
};

SideValue measure(const ClaimSide& side, const ClaimCheck& check, const GroupKey& group,
                  const std::vector<StudyRecord>& records) {
    SideValue answer;
    std::set<std::string> cells;
    std::vector<double> values;
    std::vector<std::pair<double, double>> points;
    const auto passes = side.where.find("pass");
    for (const StudyRecord& record : records) {
        if (!is_selected(record, side.where) || !belongs(check, side, record, group)) continue;
        if (!cells.insert(record.cell).second) continue;
        answer.failed = answer.failed || record.failed;
        const std::optional<double> value =
            value_of(record, side.value, passes == side.where.end() ? nullptr : &passes->second);
        if (!value) continue;
        values.push_back(*value);
        if (const auto x = record.keys.find(side.power_key); x != record.keys.end())
            points.emplace_back(number_of(x->second), *value);
    }
    answer.cells = values.size();
    if (!side.power_key.empty())
        answer.value = power_of(points);
    else if (!values.empty())
        answer.value = aggregate_of(side.aggregate, values);
    return answer;
}

bool holds(double left, const std::string& relation, double bound, double margin) {
    if (relation == "<") return left < bound;
    if (relation == "<=") return left <= bound;
    if (relation == ">") return left > bound;
    if (relation == ">=") return left >= bound;
    return std::abs(left - bound) <= margin || left == bound;
}

// How far inside its bound a group is, as a share of the bound: the least is told.
double slack(const CheckedGroup& group, const std::string& relation) {
    const double scale = std::max(std::abs(group.bound), 1e-300), distance = group.bound - group.left;
    if (relation == "=") return -std::abs(distance) / scale;
    return (relation[0] == '<' ? distance : -distance) / scale;
}

std::string number_text(const ClaimSide& side, double value) {
    return side.power_key.empty() ? quantity_text(side.value, value) : fmt::format("{:.2f}", value);
}

std::string group_text(const ClaimCheck& check, const CheckedGroup& group) {
    std::string text = number_text(check.left, group.left);
    if (check.right) text += " against " + number_text(*check.right, group.right);
    return group.name.empty() ? text : group.name + ": " + text;
}

std::string measured_text(const ClaimCheck& check, const CheckResult& result) {
    if (result.groups.empty()) return "";
    std::string text;
    if (result.groups.size() <= most_listed) {
        for (const CheckedGroup& group : result.groups)
            text += (text.empty() ? "" : "; ") + group_text(check, group) +
                    (result.groups.size() > 1 && !group.holds ? " (not)" : "");
        return text;
    }
    const auto worst =
        std::min_element(result.groups.begin(), result.groups.end(), [&](const CheckedGroup& a, const CheckedGroup& b) {
            return slack(a, check.relation) < slack(b, check.relation);
        });
    const auto good = std::count_if(result.groups.begin(), result.groups.end(),
                                    [](const CheckedGroup& group) { return group.holds; });
    return fmt::format("{} of {}; {} {}", good, result.groups.size(),
                       good == static_cast<std::ptrdiff_t>(result.groups.size()) ? "closest" : "worst",
                       group_text(check, *worst));
}

CheckResult judge_check(const ClaimCheck& check, const StudyLabels& labels, const std::vector<StudyRecord>& records) {
    CheckResult result;
    if (check.is_test()) {
        result.formula = fmt::format("test '{}' ({})", check.test_name, check.test_file);
        result.measured = check.test_measured;
        result.verdict = check.test_holds ? Verdict::Holds : Verdict::Fails;
        return result;
    }
    result.formula = formula_of(check, labels);
    std::vector<GroupKey> groups;
    for (const StudyRecord& record : records)
        if (is_selected(record, check.left.where))
            if (const GroupKey group = group_of(check, record);
                std::find(groups.begin(), groups.end(), group) == groups.end())
                groups.push_back(group);
    std::string why = groups.empty() ? "no rows: scenes were skipped or cells are missing" : "";
    for (const GroupKey& key : groups) {
        const SideValue left = measure(check.left, check, key, records);
        const SideValue right = check.right ? measure(*check.right, check, key, records) : SideValue{0.0, 0, false};
        if (left.failed || right.failed || !left.value || !right.value) {
            why = left.failed || right.failed ? "cells failed" : "no cell has such a value";
            continue;
        }
        CheckedGroup group;
        for (size_t i = 0; i < key.size(); ++i)
            if (!key[i].empty())
                group.name += fmt::format("{}{} {}", group.name.empty() ? "" : ", ", key_title(check.per[i]),
                                          label_of(labels, check.per[i], key[i]));
        group.left = *left.value, group.right = *right.value;
        group.left_rows = left.cells, group.right_rows = right.cells;
        group.bound = (check.right ? check.factor * group.right : 0.0) + check.offset;
        group.holds = holds(group.left, check.relation, group.bound, check.margin);
        result.groups.push_back(std::move(group));
    }
    result.measured = measured_text(check, result);
    if (!why.empty()) result.measured += (result.measured.empty() ? "" : "; besides ") + why;
    const auto good = std::count_if(result.groups.begin(), result.groups.end(),
                                    [](const CheckedGroup& group) { return group.holds; });
    if (!result.groups.empty())
        result.verdict = static_cast<size_t>(good) < result.groups.size() ? Verdict::Fails
                         : why.empty()                                    ? Verdict::Holds
                                                                          : Verdict::InPart;
    return result;
}

ordered_json finite(double value) { return std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr); }

ordered_json check_json(const ClaimCheck& check, const CheckResult& result) {
    ordered_json groups = ordered_json::array();
    for (const CheckedGroup& group : result.groups)
        groups.push_back({{"name", group.name},
                          {"left", finite(group.left)},
                          {"right", finite(group.right)},
                          {"bound", finite(group.bound)},
                          {"left_cells", group.left_rows},
                          {"right_cells", group.right_rows},
                          {"holds", group.holds}});
    return {{"text", check.text},
            {"formula", result.formula},
            {"verdict", verdict_text(result.verdict)},
            {"measured", result.measured},
            {"groups", std::move(groups)}};
}

} // namespace

const char* verdict_text(Verdict verdict) {
    switch (verdict) {
    case Verdict::Holds:
        return "holds";
    case Verdict::InPart:
        return "holds in part";
    case Verdict::Fails:
        return "does not hold";
    default:
        return "not measured";
    }
}

ClaimResult judge(const StudyClaim& claim, const StudyLabels& labels, const std::vector<StudyRecord>& records) {
    ClaimResult result;
    size_t count[4] = {};
    for (const ClaimCheck& check : claim.checks) {
        result.checks.push_back(judge_check(check, labels, records));
        ++count[static_cast<size_t>(result.checks.back().verdict)];
    }
    const auto all = [&](Verdict verdict) { return count[static_cast<size_t>(verdict)] == claim.checks.size(); };
    if (all(Verdict::Holds))
        result.verdict = Verdict::Holds;
    else if (all(Verdict::NotMeasured))
        result.verdict = Verdict::NotMeasured;
    else if (count[static_cast<size_t>(Verdict::Holds)] + count[static_cast<size_t>(Verdict::InPart)] == 0)
        result.verdict = Verdict::Fails;
    else
        result.verdict = Verdict::InPart;
    return result;
}

ordered_json claims_json(const StudyQuestions& questions, const std::vector<StudyRecord>& records) {
    ordered_json claims = ordered_json::array();
    for (const StudyClaim& claim : questions.claims) {
        const ClaimResult result = judge(claim, questions.labels, records);
        ordered_json checks = ordered_json::array();
        for (size_t i = 0; i < claim.checks.size(); ++i)
            checks.push_back(check_json(claim.checks[i], result.checks[i]));
        claims.push_back({{"id", claim.id},
                          {"text", claim.text},
                          {"source", claim.source},
                          {"verdict", verdict_text(result.verdict)},
                          {"note", claim.note},
                          {"checks", std::move(checks)}});
    }
    return claims;
}

} // namespace gnomon
