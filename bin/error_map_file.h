#pragma once
// The picture of `gnomon compare --map`.

#include <string>
#include <vector>

#include "core/image_file.h"
#include "eval/error_map.h"

namespace gnomon {

// Where `test` differs from `reference` in `channels`, those that a comparison named: the mean of several visibilities,
// the luminance of a colour. `masked`: pixels outside the images' M channels are grey.
void write_error_map(const std::string& path, const ChannelImage& test, const ChannelImage& reference,
                     const std::vector<std::string>& channels, bool masked, ErrorMapKind kind);

} // namespace gnomon
