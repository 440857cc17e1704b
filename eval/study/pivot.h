#pragma once
// A table of a study as it is printed: rows and columns of labels, one quantity in its places.

#include <optional>
#include <string>
#include <vector>

#include "eval/study/questions.h"

namespace gnomon {

struct StudyPlace {
    std::optional<double> value;    // none: no such row, or it has no such value
    std::optional<double> relative; // value / the baseline's in the same column
    bool failed = false;            // a cell that belongs here failed
};

struct StudyPivot {
    StudyQuantity quantity;
    std::vector<std::string> row_keys;           // as the table names them
    std::vector<std::vector<std::string>> rows;  // labels, one a key
    std::vector<std::string> columns;            // labels of the column keys, joined
    std::vector<std::vector<StudyPlace>> places; // [row][column]
};

// One pivot a quantity of the table, rows and columns in the order in which the records have them. A record that lacks
// a column key belongs to every column of its row that has none of its own; rows of several blocks that share a cell
// count once. What shares a place is aggregated; passes of one label are summed first.
std::vector<StudyPivot> make_pivots(const StudyTable& table, const std::vector<StudyRecord>& records);

// "root mean square error", "texels fetched", "CPU time"; of two: "texels fetched / masked".
std::string quantity_title(const StudyQuantity& quantity);

// The number as a reader wants it: "0.0539", "12.3 M", "8 MiB", "12.3 ms".
std::string quantity_text(const StudyQuantity& quantity, double value);

// "5.10 ms (+1.8 %)", "failed", "" where there is nothing.
std::string place_text(const StudyQuantity& quantity, const StudyPlace& place);

} // namespace gnomon
