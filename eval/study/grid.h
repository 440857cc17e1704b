#pragma once
// Parameter grids: {"technique": "pcf", "size": [512, 1024], "kernel": [3, 7]} into four variants.

#include "core/json_reader.h"
#include "eval/study/file.h"

namespace gnomon {

// The elements of an array, or the value itself as the only one. Fails where there is none.
std::vector<JsonReader> one_or_many(const JsonReader& value);

// A number, a truth value or a string as it would be written on a command line.
std::string text_of(const JsonReader& value);

// "file: place: what went wrong" instead of what `check` throws.
void check_at(const JsonReader& place, const std::function<void()>& check);

// What a key "techniques" or "truth" asks for, in its order; parameters multiply in the order of the technique's table,
// the last fastest. `shared` is an object of parameters for all techniques that have them and do not set them
// themselves, or null. `id` stands in for a missing "technique"; "" where it must be given.
std::vector<StudyVariant> read_variants(const JsonReader& list, const JsonReader* shared, const std::string& id,
                                        const StudyProgram& program);

} // namespace gnomon
