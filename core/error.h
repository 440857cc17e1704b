#pragma once
// What can go wrong because of the user or the machine, as exceptions with one whole sentence each; the command line
// prints the sentence and exits with the code. Broken invariants of ours are assertions, not errors.

#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

namespace gnomon {

enum class ExitCode {
    Done = 0,
    BoundCrossed = 1,  // a --fail-above bound was crossed
    Usage = 2,         // an unknown option, technique or parameter, a value out of range
    Input = 3,         // a file that is missing, broken or cannot be written
    Internal = 4,      // a failure of ours
    Interrupted = 130, // by SIGINT, after what was done had been saved
    Terminated = 143,  // likewise by SIGTERM
};

class Error : public std::runtime_error {
public:
    Error(ExitCode exit_code, const std::string& sentence) : std::runtime_error(sentence), code(exit_code) {}
    ExitCode code;
};

struct UsageError : Error {
    explicit UsageError(const std::string& sentence) : Error(ExitCode::Usage, sentence) {}
};

struct InputError : Error {
    explicit InputError(const std::string& sentence) : Error(ExitCode::Input, sentence) {}
};

// "; did you mean 'pcf'?" for the candidate nearest to `word` by edit distance, or "" where none is near.
std::string did_you_mean(std::string_view word, std::span<const std::string> candidates);

} // namespace gnomon
