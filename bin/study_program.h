#pragma once
// What the program lends to a study: its techniques, and how one of them answers for a view.

#include <memory>

#include "eval/study/study.h"

namespace gnomon {

// Keeps the last scene and frame, which cells that follow each other share; warnings of scenes go to standard error
// unless quiet. The functions of the result may be called as long as it or a copy of it lives.
StudyProgram make_study_program(bool quiet);

} // namespace gnomon
