#pragma once
// A study: scenes × cameras × lights × sizes × truths × techniques × parameters, in named blocks. docs/studies.md
// describes the file that asks for it and the folder that it fills.
//
// Every line of the tables is a row; what it takes to make one is a cell, kept under the hash of all that determines
// it. Rows that ask for the same share a cell. This folder knows no technique: the program lends what it takes.

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/image_file.h"
#include "core/parameters.h"

namespace gnomon {

// A technique, or a truth, with all its parameters.
struct StudyChoice {
    std::string id;
    int version = 1;
    ParameterText text;        // as written; what is left out has its default
    nlohmann::json parameters; // all of them, typed
};

// What is looked at.
struct StudyView {
    std::string scene;           // as load_scene takes it
    ParameterText camera, light; // options of `gnomon render` by their names: {"look-from": "1,2,3"}
    std::string size = "1280x720", primary = "raster";
};

// A technique's answer for a view.
struct StudyImage {
    ChannelImage image;                  // visibility, masks and whatever belongs to them
    nlohmann::ordered_json counters;     // totals over all passes and lights
    nlohmann::ordered_json passes;       // [{"light", "name", counters…}], without times; first what techniques share
    nlohmann::ordered_json pass_seconds; // [{"light", "name", "seconds"}]
    double seconds = 0;
    std::int64_t peak_bytes = 0; // of the program, while it worked on this
};

// A technique as the program knows it.
struct StudyTechnique {
    std::string id;
    int version = 1;
    std::vector<ParameterInfo> parameters;
    std::function<void(const ParameterText&)> check; // throws UsageError
};

// What the program lends to a study.
struct StudyProgram {
    std::string version;
    std::vector<StudyTechnique> techniques;
    std::vector<std::string> counters;                // names of those that StudyImage::counters has
    std::function<void(const StudyView&)> check_view; // throws UsageError; touches no file
    // `state` names a file from which a long truth may go on, and to which it may save; "" for none.
    std::function<StudyImage(const StudyView&, const StudyChoice&, const std::string& state)> render;
};

// A truth that cells are measured against.
struct PlannedTruth {
    std::string hash;
    nlohmann::ordered_json identity; // what the hash is of
    StudyView view;
    StudyChoice choice;
};

struct PlannedCell {
    std::string hash;
    nlohmann::ordered_json identity;
    StudyView view;
    StudyChoice technique;
    std::size_t truth = 0;            // index into StudyPlan::truths
    std::vector<std::string> metrics; // ids, in the order of metrics()
};

// A line of the tables before its results are known.
struct PlannedRow {
    std::size_t cell = 0;        // index into StudyPlan::cells
    nlohmann::ordered_json head; // {"cell", "block", "scene", …, "reference"}
};

// A scene that the file calls optional and that is not there.
struct SkippedScene {
    std::string name, missing; // missing: the file, as the study or the scene calls it
};

struct StudyPlan {
    std::string name;
    nlohmann::json questions; // tables and claims, as they stand in the file
    std::vector<SkippedScene> skipped;
    std::vector<PlannedRow> rows; // in the order of the file
    std::vector<PlannedCell> cells;
    std::vector<PlannedTruth> truths;
};

// Reads a study and settles all that it asks for, without loading a scene. Throws InputError with one line that names
// the file and the place in it.
StudyPlan read_study(const std::string& path, const StudyProgram& program);

// Part `part` of `parts` (from 1) has the cells i with i mod parts = part − 1.
struct StudyShare {
    int part = 1, parts = 1;
    bool has(std::size_t cell) const {
        return cell % static_cast<std::size_t>(parts) == static_cast<std::size_t>(part - 1);
    }
};

struct StudyRun {
    StudyShare share;
    bool retry_failed = false; // cells that failed before are computed again
    bool progress = false;
};

struct StudySummary {
    std::size_t cells = 0;     // of the study
    std::size_t share = 0;     // of them, those of the share
    std::size_t there = 0;     // of the share, those that an earlier run had computed
    std::size_t computed = 0;  // of the share, now
    std::size_t failed = 0;    // of the share, now or before
    std::string first_failure; // message of the first of them
    std::size_t missing = 0;   // of the study, still: the tables are written once there is none
};

// The study ran to its end, but some of its cells failed.
inline constexpr ExitCode cells_failed{1};

// Computes what `folder` lacks of the share, and writes the tables if then nothing is missing. Throws InputError where
// the folder cannot be written.
StudySummary run_study(const StudyPlan& plan, const StudyProgram& program, const std::string& folder,
                       const StudyRun& run);

// Writes the tables of the study that `folder` was last run for; with `partial` also where cells are missing, whose
// rows are left out. Throws InputError where it holds no study, and, unless partial, where cells are missing.
StudySummary collect_study(const std::string& folder, bool partial);

// One line per row: what is known of its cell in `folder`, which need not exist, and what it is.
std::string list_study(const StudyPlan& plan, const std::string& folder);

} // namespace gnomon
