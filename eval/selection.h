#pragma once
// Which channels of two images meet, and which pixels take part: what a comparison and its error maps have in common.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/image_file.h"
#include "eval/metrics.h"

namespace gnomon {

enum class MaskSource {
    Images, // `<light>.M` beside a channel `<light>.V`, or else `M`: receivers that face the light; of both images
            // where both have one
    None,   // all pixels
    Given,  // CompareOptions::mask alone
};

struct CompareOptions {
    std::string test_name = "test", reference_name = "reference"; // in errors and in the result
    std::vector<std::string> metrics;                             // ids; empty or {"all"}: every metric that applies
    // Empty: the visibility channels where both images have them, else R, G, B, else Y. "a.V", or "a.V=b.V" where the
    // reference's has another name, or a layer: "diffuse" for diffuse.R, diffuse.G, diffuse.B.
    std::vector<std::string> channels;
    bool as_visibility = false; // the channels are visibilities, whatever they are called
    MaskSource mask_source = MaskSource::Images;
    Image<std::uint8_t> mask;   // 1 in, 0 out; unless empty, it also narrows the images' own
    bool only_penumbra = false; // of the reference; of visibilities alone
};

struct ComparedChannel {
    std::string name; // of the test
    const Image<float>*test, *reference;
};

// Channels that share a mask: one visibility, the components of a colour, or other data.
struct ChannelGroup {
    enum class Kind { Visibility, Color, Data } kind = Kind::Visibility;
    std::vector<ComparedChannel> channels; // of a colour: R, G, B or those of them that were chosen; or Y
    Image<std::uint8_t> mask;              // empty: all pixels
    bool srgb = false;

    ImagePair pair(size_t channel) const { return {*channels[channel].test, *channels[channel].reference, mask, srgb}; }
    std::optional<ColorPair> color() const; // of a colour or a visibility, as grey; none where components lack
};

// The images must outlive the groups. Throws InputError naming both files where sizes differ, a channel is missing, the
// images have none in common, or one is display-referred and the other scene-linear; UsageError for a penumbra of
// colours.
std::vector<ChannelGroup> select_channels(const ChannelImage& test, const ChannelImage& reference,
                                          const CompareOptions& options);

// Whether the colours are sRGB codes, as in a PNG. Visibility and data are never.
bool is_srgb_coded(const ChannelImage& image);

// Where one image holds sRGB codes and the other scene-linear colours, makes the codes (R, G, B, Y) scene-linear too.
void match_encodings(ChannelImage& test, ChannelImage& reference);

// Pixels from the left and from the top, as viewers count them; throws InputError where it leaves the image.
Image<std::uint8_t> rectangle_mask(int width, int height, int left, int top, int rectangle_width, int rectangle_height);

// Pixels whose layer has one of the ids. Throws InputError where the image lacks the layer.
Image<std::uint8_t> id_mask(const ChannelImage& image, const std::string& image_name, const std::string& layer,
                            const std::vector<std::int64_t>& ids);

} // namespace gnomon
