#pragma once
// Files that appear whole or not at all: written under a temporary name beside the target, flushed, then renamed over
// it.

#include <functional>
#include <string>
#include <string_view>

namespace gnomon {

// `write` fills the file at the temporary path it is given (same folder; same extension as `path`). If it throws, the
// temporary file is removed and `path` is as it was. Throws InputError naming `path` where the folder is missing or
// cannot be written.
void write_atomically(const std::string& path, const std::function<void(const std::string& temporary_path)>& write);

void write_text_file(const std::string& path, std::string_view text);

// The whole file. Throws InputError where it cannot be read.
std::string read_file(const std::string& path);

} // namespace gnomon
