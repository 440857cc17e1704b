#include "eval/study/pivot.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "eval/metrics.h"

namespace gnomon {
namespace {

using Labels = std::vector<std::string>;

const char* const no_label = "–";

bool has(const std::vector<std::string>& list, const std::string& text) {
    return std::find(list.begin(), list.end(), text) != list.end();
}

// One record, or the passes of one that share a label.
struct Portion {
    const StudyRecord* record;
    std::string pass;                // label
    std::vector<std::string> passes; // names; empty for the whole record
};

std::vector<Portion> portions_of(const StudyTable& table, const StudyRecord& record) {
    if (!has(table.rows, "pass") && !has(table.columns, "pass")) return {{&record, "", {}}};
    std::vector<Portion> portions;
    const auto chosen = table.where.find("pass");
    for (const StudyPass& pass : record.passes) {
        if (chosen != table.where.end() && !has(chosen->second, pass.name)) continue;
        const std::string label = label_of(table.labels, "pass", pass.name);
        auto found = std::find_if(portions.begin(), portions.end(),
                                  [&](const Portion& portion) { return portion.pass == label; });
        if (found == portions.end()) found = portions.insert(found, {&record, label, {}});
        found->passes.push_back(pass.name);
    }
    return portions;
}

// Nothing where the record lacks one of the keys and `strict`.
std::optional<Labels> labels_of(const StudyTable& table, const std::vector<std::string>& keys, const Portion& portion,
                                bool strict) {
    Labels labels;
    for (const std::string& key : keys) {
        const auto found = portion.record->keys.find(key);
        if (key == "pass")
            labels.push_back(portion.pass);
        else if (found != portion.record->keys.end())
            labels.push_back(label_of(table.labels, key, found->second));
        else if (strict)
            return {};
        else
            labels.push_back(no_label);
    }
    return labels;
}

// What has come together in one place.
struct Heap {
    std::set<std::string> cells;
    std::vector<double> values;
    bool failed = false;
};

void add_to(Heap& heap, const Portion& portion, const StudyQuantity& quantity) {
    if (!heap.cells.insert(portion.record->cell).second) return;
    if (portion.record->failed) {
        heap.failed = true;
        return;
    }
    const std::optional<double> value =
        value_of(*portion.record, quantity, portion.passes.empty() ? nullptr : &portion.passes);
    if (value) heap.values.push_back(*value);
}

StudyPlace place_of(const Heap& heap, const std::string& aggregate) {
    StudyPlace place;
    place.failed = heap.failed;
    if (!heap.values.empty() && !heap.failed) place.value = aggregate_of(aggregate, heap.values);
    return place;
}

template <class T> size_t index_in(std::vector<T>& list, const T& one) {
    const auto found = std::find(list.begin(), list.end(), one);
    if (found != list.end()) return static_cast<size_t>(found - list.begin());
    list.push_back(one);
    return list.size() - 1;
}

class PivotMaker {
public:
    PivotMaker(const StudyTable& table, const StudyQuantity& quantity) : table_(table) { pivot_.quantity = quantity; }

    StudyPivot make(const std::vector<StudyRecord>& records) {
        pivot_.row_keys = table_.rows;
        for (const StudyRecord& record : records)
            if (is_selected(record, table_.where))
                for (const Portion& portion : portions_of(table_, record)) add(portion);
        for (size_t row = 0; row < pivot_.rows.size(); ++row) {
            std::vector<StudyPlace>& places = pivot_.places.emplace_back();
            for (size_t column = 0; column < std::max<size_t>(1, pivot_.columns.size()); ++column) {
                const auto own = heaps_.find({row, column});
                places.push_back(place_of(own != heaps_.end() ? own->second : everywhere_[row], table_.aggregate));
            }
        }
        if (pivot_.columns.empty()) pivot_.columns.push_back(no_label);
        compare_with_baseline();
        return std::move(pivot_);
    }

private:
    void add(const Portion& portion) {
        const size_t row = index_in(pivot_.rows, *labels_of(table_, table_.rows, portion, false));
        const std::optional<Labels> column = labels_of(table_, table_.columns, portion, true);
        Heap& heap = column ? heaps_[{row, index_in(pivot_.columns, fmt::format("{}", fmt::join(*column, ", ")))}]
                            : everywhere_[row];
        add_to(heap, portion, pivot_.quantity);
    }

    void compare_with_baseline() {
        if (table_.baseline.empty()) return;
        for (size_t row = 0; row < pivot_.rows.size(); ++row) {
            Labels base = pivot_.rows[row];
            for (size_t i = 0; i < table_.rows.size(); ++i)
                if (const auto own = table_.baseline.find(table_.rows[i]); own != table_.baseline.end())
                    base[i] = label_of(table_.labels, table_.rows[i], own->second[0]);
            const auto found = std::find(pivot_.rows.begin(), pivot_.rows.end(), base);
            if (found == pivot_.rows.end() || base == pivot_.rows[row]) continue;
            const std::vector<StudyPlace>& against = pivot_.places[static_cast<size_t>(found - pivot_.rows.begin())];
            for (size_t column = 0; column < pivot_.columns.size(); ++column) {
                StudyPlace& place = pivot_.places[row][column];
                if (place.value && against[column].value && *against[column].value != 0)
                    place.relative = *place.value / *against[column].value;
            }
        }
    }

    const StudyTable& table_;
    StudyPivot pivot_;
    std::map<std::pair<size_t, size_t>, Heap> heaps_; // row, column
    std::map<size_t, Heap> everywhere_;               // of rows: what belongs to no column
};

std::string value_title(const std::string& id) {
    for (const Metric& metric : metrics())
        if (metric.id == id) return metric.title;
    if (id == "seconds") return "CPU time";
    std::string words = id;
    std::replace(words.begin(), words.end(), '_', ' ');
    return words;
}

bool is_metric(const std::string& id) {
    return std::any_of(metrics().begin(), metrics().end(), [&](const Metric& metric) { return metric.id == id; });
}

std::string scaled(double value, std::initializer_list<std::pair<double, const char*>> units, const char* smallest) {
    for (const auto& [size, name] : units)
        if (std::abs(value) >= size) return fmt::format("{:.3g} {}", value / size, name);
    return fmt::format("{:.3g}{}{}", value, *smallest ? " " : "", smallest);
}

} // namespace

std::vector<StudyPivot> make_pivots(const StudyTable& table, const std::vector<StudyRecord>& records) {
    std::vector<StudyPivot> pivots;
    for (const StudyQuantity& quantity : table.values) pivots.push_back(PivotMaker(table, quantity).make(records));
    return pivots;
}

std::string quantity_title(const StudyQuantity& quantity) {
    return quantity.operation
               ? fmt::format("{} {} {}", value_title(quantity.first), quantity.operation, value_title(quantity.second))
               : value_title(quantity.first);
}

std::string quantity_text(const StudyQuantity& quantity, double value) {
    const std::string& id = quantity.first;
    if (std::isinf(value)) return value > 0 ? "∞" : "−∞";
    if (is_metric(id) || quantity.operation == '/') return fmt::format("{:.4g}", value);
    if (id == "seconds") return fmt::format("{:.3g} {}", value < 1 ? value * 1e3 : value, value < 1 ? "ms" : "s");
    if (id.find("bytes") != std::string::npos)
        return scaled(value, {{0x1p30, "GiB"}, {0x1p20, "MiB"}, {0x1p10, "KiB"}}, "B");
    if (std::abs(value) < 1000) return fmt::format("{:g}", value);
    return scaled(value, {{1e9, "G"}, {1e6, "M"}, {1e3, "k"}}, "");
}

std::string place_text(const StudyQuantity& quantity, const StudyPlace& place) {
    if (place.failed) return "failed";
    if (!place.value) return "";
    std::string text = quantity_text(quantity, *place.value);
    if (place.relative && std::isfinite(*place.relative)) {
        const double percent = (*place.relative - 1) * 100;
        text += fmt::format(" ({:+.{}f} %)", percent, std::abs(percent) < 100 ? 1 : 0);
    }
    return text;
}

} // namespace gnomon
