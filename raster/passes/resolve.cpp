#include "raster/passes/resolve.h"

#include "core/error.h"
#include "raster/full_screen.h"

namespace gnomon {
namespace {

vec4 combine(ResolveMode mode, vec4 a, vec4 b) {
    switch (mode) {
    case ResolveMode::Average:
        return a + b;
    case ResolveMode::Sample0:
        return a;
    case ResolveMode::Minimum:
        return glm::min(a, b);
    case ResolveMode::Maximum:
        return glm::max(a, b);
    }
    return a;
}

} // namespace

void resolve_samples(Pass& pass, const Target& multi, Target& single, int samples, ResolveMode mode) {
    const bool depth = info(multi.format()).kind == FormatInfo::Kind::Depth;
    if (multi.format() != single.format() || multi.width() != single.width() || multi.height() != single.height() ||
        multi.layers() != single.layers() * samples)
        throw UsageError("a resolve needs targets of one format and size, with a layer for every sample");
    if (depth && mode == ResolveMode::Average)
        throw UsageError("depths of several samples have no average to resolve to");
    const std::int64_t read = samples * static_cast<std::int64_t>(info(multi.format()).bytes);
    for (int layer = 0; layer < single.layers(); ++layer)
        detail::for_each_row(pass, single.height(), [&](int y, PassCounters& counters) {
            for (int x = 0; x < single.width(); ++x) {
                vec4 value = multi.load(x, y, layer * samples);
                for (int s = 1; s < samples; ++s) value = combine(mode, value, multi.load(x, y, layer * samples + s));
                if (mode == ResolveMode::Average) value = value / static_cast<float>(samples);
                if (depth)
                    single.store_key(x, y, layer, depth_key(single.format(), static_cast<double>(value.x)));
                else
                    single.store(x, y, layer, value);
            }
            counters.fragments_shaded += single.width();
            counters.texels_fetched += samples * single.width();
            counters.bytes_read += read * single.width();
            counters.bytes_written += single.width() * info(single.format()).bytes;
        });
}

} // namespace gnomon
