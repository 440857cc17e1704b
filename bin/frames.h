#pragma once
// Sequences of images on the command line: a folder, or a name with a run of # where the frame's number stands.

#include <string>
#include <vector>

namespace gnomon {

struct FramePair {
    std::string name; // the frame's number, or the file's name in both folders
    std::string test, reference;
};

// Whether the name means a sequence: a folder, or it has # in it and is no file itself.
bool is_sequence(const std::string& name);

// Frames that both have, in the order of their numbers or names. `####.exr` is four digits or more. Throws UsageError
// where one is a folder and the other is not, InputError where a frame is in one of the two alone or there is none.
std::vector<FramePair> pair_frames(const std::string& test, const std::string& reference);

} // namespace gnomon
