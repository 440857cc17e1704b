#pragma once
// Which pixels `gnomon compare` measures, beside the images' own masks: --mask, which may be repeated.

#include <cstdint>
#include <string>
#include <vector>

#include "core/image_file.h"

namespace gnomon {

struct MaskRequest {
    bool penumbra = false;
    std::vector<std::vector<int>> rectangles; // left, top, width, height
    struct Ids {
        std::string layer;
        std::vector<std::int64_t> ids;
    };
    std::vector<Ids> ids;
    std::vector<std::string> files; // first channel, in from one half
};

// "penumbra", "rect:X,Y,W,H", "id:7,9", "id:LAYER=7,9", "file:NAME". Throws UsageError.
MaskRequest read_masks(const std::vector<std::string>& texts);

// What lies in all of them but the penumbra, which the comparison finds; empty where there is nothing to narrow. Ids
// are looked up in the reference, or in the test where only that has the layer. Throws InputError.
Image<std::uint8_t> make_mask(const MaskRequest& request, const std::string& test_name, const ChannelImage& test,
                              const std::string& reference_name, const ChannelImage& reference);

} // namespace gnomon
