#include "bin/mask_options.h"

#include <fmt/format.h>

#include "bin/text.h"
#include "core/error.h"
#include "eval/selection.h"

namespace gnomon {
namespace {

MaskRequest::Ids read_ids(const std::string& text) {
    const size_t equals = text.find('=');
    MaskRequest::Ids ids{equals == std::string::npos ? "id" : text.substr(0, equals), {}};
    const std::string list = equals == std::string::npos ? text : text.substr(equals + 1);
    constexpr int exact_in_float = 1 << 24;
    for (const std::string& id : split(list, ','))
        ids.ids.push_back(parse_integer(id, "--mask id", -1, exact_in_float));
    return ids;
}

void narrow(Image<std::uint8_t>& mask, const Image<std::uint8_t>& by) {
    if (mask.empty())
        mask = by;
    else
        for (size_t i = 0; i < mask.size(); ++i) mask.values()[i] &= by.values()[i];
}

Image<std::uint8_t> file_mask(const std::string& path, int width, int height) {
    const ChannelImage image = read_image(path);
    if (image.width != width || image.height != height)
        throw InputError(fmt::format("the mask '{}' is {}x{}, but the images are {}x{}", path, image.width,
                                     image.height, width, height));
    Image<std::uint8_t> mask(width, height, 0);
    for (size_t i = 0; i < mask.size(); ++i) mask.values()[i] = image.channels[0].values.values()[i] >= 0.5f;
    return mask;
}

} // namespace

MaskRequest read_masks(const std::vector<std::string>& texts) {
    MaskRequest request;
    for (const std::string& text : texts) {
        const size_t colon = text.find(':');
        const std::string kind = text.substr(0, colon), rest = colon == std::string::npos ? "" : text.substr(colon + 1);
        const size_t choice = parse_choice(kind, "--mask", {"penumbra", "rect", "id", "file"});
        if (choice == 0 ? colon != std::string::npos : rest.empty())
            throw UsageError(fmt::format("--mask is '{}', but must be penumbra, rect:X,Y,W,H, id:NUMBER,..., "
                                         "id:LAYER=NUMBER,... or file:NAME",
                                         text));
        if (choice == 0) request.penumbra = true;
        if (choice == 1) {
            std::vector<int> rectangle;
            for (const std::string& number : split(rest, ','))
                rectangle.push_back(parse_integer(number, "--mask rect", 0, max_image_side));
            if (rectangle.size() != 4)
                throw UsageError(fmt::format("--mask is '{}', but a rectangle is rect:LEFT,TOP,WIDTH,HEIGHT", text));
            request.rectangles.push_back(rectangle);
        }
        if (choice == 2) request.ids.push_back(read_ids(rest));
        if (choice == 3) request.files.push_back(rest);
    }
    return request;
}

Image<std::uint8_t> make_mask(const MaskRequest& request, const std::string& test_name, const ChannelImage& test,
                              const std::string& reference_name, const ChannelImage& reference) {
    Image<std::uint8_t> mask;
    for (const std::vector<int>& r : request.rectangles)
        narrow(mask, rectangle_mask(reference.width, reference.height, r[0], r[1], r[2], r[3]));
    for (const MaskRequest::Ids& ids : request.ids) {
        const bool in_test = !reference.find(ids.layer) && test.find(ids.layer) && test.width == reference.width &&
                             test.height == reference.height;
        narrow(mask, in_test ? id_mask(test, test_name, ids.layer, ids.ids)
                             : id_mask(reference, reference_name, ids.layer, ids.ids));
    }
    for (const std::string& file : request.files) narrow(mask, file_mask(file, reference.width, reference.height));
    return mask;
}

} // namespace gnomon
