#include "core/digest.h"

#include <fmt/format.h>

namespace gnomon {

std::string Digest::text() const { return fmt::format("{:016x}", value_); }

} // namespace gnomon
