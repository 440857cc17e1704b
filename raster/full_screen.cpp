#include "raster/full_screen.h"

namespace gnomon::detail {

void write_pixel(const Targets& targets, const BlendState& state, const Pixel& pixel) {
    for (size_t i = 0; i < targets.color.size(); ++i) {
        Target& target = *targets.color[i];
        const FormatInfo& format = info(target.format());
        pixel.counters.bytes_written += format.bytes;
        if (format.kind == FormatInfo::Kind::Uint) {
            target.store_uint(pixel.x, pixel.y, targets.layer, glm::floatBitsToUint(pixel.color[i]), 15, targets.level);
        } else if (state.enabled) {
            pixel.counters.bytes_read += format.bytes;
            const vec4 old = target.load(pixel.x, pixel.y, targets.layer, targets.level);
            target.store(pixel.x, pixel.y, targets.layer, blend(state, pixel.color[i], old), 15, targets.level);
        } else {
            target.store(pixel.x, pixel.y, targets.layer, pixel.color[i], 15, targets.level);
        }
    }
}

} // namespace gnomon::detail
