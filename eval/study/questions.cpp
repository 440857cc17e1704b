#include "eval/study/questions.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "core/error.h"
#include "eval/study/grid.h"

namespace gnomon {
namespace {

const std::vector<std::string> plain_keys = {"block", "scene", "camera",    "light",
                                             "size",  "pass",  "technique", "reference.technique"};
constexpr double any_number = 1e300;

std::vector<std::string> texts(const JsonReader& value) {
    std::vector<std::string> list;
    for (const JsonReader& element : one_or_many(value)) list.push_back(text_of(element));
    return list;
}

std::string optional_text(const JsonReader& object, const std::string& key) {
    return object.has(key) ? object.at(key).text() : "";
}

class QuestionReader {
public:
    explicit QuestionReader(const StudyVocabulary* vocabulary) : vocabulary_(vocabulary) {}

    StudyQuestions read(const JsonReader& document) {
        StudyQuestions questions;
        questions.description = optional_text(document, "description");
        if (document.has("notes")) questions.notes = texts(document.at("notes"));
        if (document.has("labels")) questions.labels = read_labels(document.at("labels"));
        std::set<std::string> names;
        if (document.has("tables"))
            for (const JsonReader& place : one_or_many(document.at("tables"))) {
                questions.tables.push_back(read_table(place, questions.labels));
                if (!names.insert(questions.tables.back().name).second)
                    place.at("name").fail("is '" + questions.tables.back().name + "', as another table is called");
            }
        names.clear();
        if (document.has("claims"))
            for (const JsonReader& place : one_or_many(document.at("claims"))) {
                questions.claims.push_back(read_claim(place));
                if (!names.insert(questions.claims.back().id).second)
                    place.at("id").fail("is '" + questions.claims.back().id + "', as another claim's is");
            }
        return questions;
    }

private:
    void check_key(const JsonReader& place, const std::string& key) const {
        if (key.starts_with("parameters.") || key.starts_with("reference.parameters.")) return;
        if (std::find(plain_keys.begin(), plain_keys.end(), key) == plain_keys.end())
            place.fail(fmt::format("is '{}', which is no key of a row{}; parameters are parameters.NAME", key,
                                   did_you_mean(key, plain_keys)));
    }

    std::vector<std::string> read_keys(const JsonReader& place) const {
        const std::vector<JsonReader> elements = one_or_many(place);
        std::vector<std::string> keys;
        for (const JsonReader& element : elements) {
            check_key(element, element.text());
            keys.push_back(element.text());
        }
        return keys;
    }

    StudyLabels read_labels(const JsonReader& place) const {
        StudyLabels labels;
        place.expect_object();
        for (const auto& item : place.value().items()) {
            const JsonReader words = place.at(item.key());
            check_key(words, item.key());
            words.expect_object();
            for (const auto& word : words.value().items()) labels[item.key()][word.key()] = words.at(word.key()).text();
        }
        return labels;
    }

    StudySelection read_selection(const JsonReader& place) const {
        StudySelection selection;
        place.expect_object();
        for (const auto& item : place.value().items()) {
            const JsonReader choice = place.at(item.key());
            check_key(choice, item.key());
            selection[item.key()] = texts(choice);
            if (item.key() == "technique") check_techniques(choice);
        }
        return selection;
    }

    void check_techniques(const JsonReader& place) const {
        if (!vocabulary_) return;
        const std::vector<std::string>& ids = vocabulary_->techniques;
        for (const JsonReader& element : one_or_many(place))
            if (std::find(ids.begin(), ids.end(), element.text()) == ids.end())
                element.fail(
                    fmt::format("is '{}', which is no technique{}", element.text(), did_you_mean(element.text(), ids)));
    }

    // Fails where no row is chosen, and names the key that is to blame if one is.
    void check_selection(const JsonReader& place, const StudySelection& selection) const {
        if (!vocabulary_) return;
        const auto chooses_any = [&](const StudySelection& some) {
            return std::any_of(vocabulary_->rows.begin(), vocabulary_->rows.end(),
                               [&](const StudyRecord& row) { return is_selected(row, some); });
        };
        if (chooses_any(selection)) return;
        for (const auto& [key, choice] : selection)
            if (!chooses_any({{key, choice}}))
                place.fail(
                    fmt::format("chooses no row of the study: none has {} '{}'", key, fmt::join(choice, "' or '")));
        place.fail("chooses no row of the study: no row has all that it asks for");
    }

    void check_value(const JsonReader& place, const std::string& id) const {
        if (!vocabulary_) return;
        const std::vector<std::string>& ids = vocabulary_->values;
        if (std::find(ids.begin(), ids.end(), id) == ids.end())
            place.fail(fmt::format("has '{}', which is neither a metric nor a counter nor a time{}", id,
                                   did_you_mean(id, ids)));
    }

    StudyQuantity read_quantity(const JsonReader& place) const {
        const std::string text = place.text();
        const size_t at = text.find_first_of("+-/");
        StudyQuantity quantity{text.substr(0, at), "", 0};
        if (at != std::string::npos) quantity.operation = text[at], quantity.second = text.substr(at + 1);
        check_value(place, quantity.first);
        if (quantity.operation) check_value(place, quantity.second);
        return quantity;
    }

    std::string read_word(const JsonReader& place, const std::vector<std::string>& words) const {
        const std::string word = place.text();
        if (std::find(words.begin(), words.end(), word) == words.end())
            place.fail(fmt::format("is '{}', but must be one of {}", word, fmt::join(words, ", ")));
        return word;
    }

    StudyTable read_table(const JsonReader& place, const StudyLabels& labels) const {
        place.only({"name", "title", "source", "note", "where", "rows", "columns", "values", "aggregate", "baseline",
                    "labels"});
        StudyTable table;
        table.name = place.at("name").text();
        table.title = optional_text(place, "title"), table.source = optional_text(place, "source");
        table.note = optional_text(place, "note");
        if (place.has("where")) {
            table.where = read_selection(place.at("where"));
            check_selection(place.at("where"), table.where);
        }
        table.rows = read_keys(place.at("rows"));
        table.columns = read_keys(place.at("columns"));
        for (const JsonReader& value : one_or_many(place.at("values"))) table.values.push_back(read_quantity(value));
        if (place.has("aggregate")) table.aggregate = read_word(place.at("aggregate"), aggregate_names());
        if (place.has("baseline")) table.baseline = read_baseline(place.at("baseline"), table.rows);
        table.labels = labels;
        if (place.has("labels"))
            for (auto& [key, words] : read_labels(place.at("labels"))) table.labels[key] = std::move(words);
        return table;
    }

    StudySelection read_baseline(const JsonReader& place, const std::vector<std::string>& rows) const {
        const StudySelection baseline = read_selection(place);
        for (const auto& [key, choice] : baseline) {
            if (std::find(rows.begin(), rows.end(), key) == rows.end())
                place.at(key).fail("is not among the keys of the table's rows");
            if (choice.size() != 1) place.at(key).fail("must be one text, since the baseline is one row");
        }
        check_selection(place, baseline);
        return baseline;
    }

    StudyClaim read_claim(const JsonReader& place) const {
        place.only({"id", "text", "source", "note", "checks"});
        StudyClaim claim{place.at("id").text(),
                         place.at("text").text(),
                         optional_text(place, "source"),
                         optional_text(place, "note"),
                         {}};
        for (const JsonReader& check : one_or_many(place.at("checks"))) claim.checks.push_back(read_check(check));
        return claim;
    }

    ClaimCheck read_check(const JsonReader& place) const {
        if (place.has("test")) return read_test(place);
        place.only({"text", "value", "where", "aggregate", "power_of", "is", "number", "times", "plus", "than",
                    "within", "per"});
        ClaimCheck check;
        check.text = optional_text(place, "text");
        check.left = read_side(place, nullptr);
        check_selection(place.has("where") ? place.at("where") : place, check.left.where);
        check.relation = read_word(place.at("is"), {"<", "<=", ">", ">=", "="});
        if (place.has("number") == place.has("than"))
            place.fail("must have either 'number' or 'than', to compare with");
        if (place.has("number")) {
            place.only({"text", "value", "where", "aggregate", "power_of", "is", "number", "within", "per"});
            check.offset = place.at("number").number(-any_number, any_number);
        } else {
            const JsonReader than = place.at("than");
            than.only({"value", "where", "aggregate", "power_of"});
            check.right = read_side(than, &check.left);
            check_selection(than, check.right->where);
            if (place.has("times")) check.factor = place.at("times").number(-any_number, any_number);
            if (place.has("plus")) check.offset = place.at("plus").number(-any_number, any_number);
        }
        if (place.has("within")) {
            if (check.relation != "=") place.at("within").fail("belongs to '=' alone");
            check.margin = place.at("within").number(0, any_number);
        }
        if (place.has("per")) check.per = read_keys(place.at("per"));
        return check;
    }

    // What the right side does not say is as on the left; of `where`, key by key.
    ClaimSide read_side(const JsonReader& place, const ClaimSide* left) const {
        ClaimSide side = left ? *left : ClaimSide{};
        if (!left || place.has("value")) side.value = read_quantity(place.at("value"));
        if (place.has("where"))
            for (auto& [key, choice] : read_selection(place.at("where"))) side.where[key] = std::move(choice);
        if (place.has("aggregate")) side.aggregate = read_word(place.at("aggregate"), aggregate_names());
        if (place.has("power_of")) {
            side.power_key = place.at("power_of").text();
            check_key(place.at("power_of"), side.power_key);
        }
        return side;
    }

    static ClaimCheck read_test(const JsonReader& place) {
        place.only({"text", "test", "case", "measured", "holds"});
        ClaimCheck check;
        check.text = optional_text(place, "text");
        check.test_file = place.at("test").text(), check.test_name = place.at("case").text();
        check.test_measured = place.at("measured").text(), check.test_holds = place.at("holds").boolean();
        if (check.test_file.empty()) place.at("test").fail("must name the file of the test");
        return check;
    }

    const StudyVocabulary* vocabulary_;
};

} // namespace

std::string label_of(const StudyLabels& labels, const std::string& key, const std::string& text) {
    const auto words = labels.find(key);
    if (words == labels.end()) return text;
    const auto word = words->second.find(text);
    return word == words->second.end() ? text : word->second;
}

std::string key_title(const std::string& key) {
    if (key == "size") return "image";
    return key.starts_with("parameters.") ? key.substr(std::string("parameters.").size()) : key;
}

const JsonReader::Keys& question_keys() {
    static const JsonReader::Keys keys = {"description", "notes", "labels", "tables", "claims"};
    return keys;
}

StudyQuestions read_questions(const JsonReader& document, const StudyVocabulary* vocabulary) {
    return QuestionReader(vocabulary).read(document);
}

} // namespace gnomon
