#include "core/image.h"

#include <fmt/format.h>

namespace gnomon {

void check_image_size(int width, int height, const char* what) {
    if (width < 1 || height < 1 || width > max_image_side || height > max_image_side)
        throw UsageError(fmt::format("a {} of {}x{} is not possible; each side must be between 1 and {} pixels", what,
                                     width, height, max_image_side));
}

} // namespace gnomon
