#pragma once
// The pages of docs/techniques, made from the registry: what `gnomon help` tells, as Markdown.

#include <string>

#include "techniques/technique.h"

namespace gnomon {

// ID.md: beside it stands ID.png.
std::string technique_page(const Entry& entry);

// README.md: all techniques by family, with links to their pages.
std::string technique_index();

} // namespace gnomon
