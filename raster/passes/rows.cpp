#include "raster/passes/rows.h"

#include <cstring>

#include "core/vector_clones.h"

namespace gnomon::detail {
namespace {

// As Target::load has them.
GNOMON_VECTOR_CLONES
void load_unorm16(const std::uint16_t* values, size_t count, float* row) {
    for (size_t i = 0; i < count; ++i) row[i] = static_cast<float>(values[i]) / 65535.0f;
}

} // namespace

void load_row(const Target& source, int y, int layer, int reach, std::vector<float>& row) {
    const FormatInfo& format = info(source.format());
    const int channels = format.channels, width = source.width();
    row.resize(static_cast<size_t>((width + 2 * reach) * channels));
    float* first = row.data() + reach * channels;
    if (format.kind == FormatInfo::Kind::Float || source.format() == Format::D32F) {
        std::memcpy(first, source.texel(0, y, layer), static_cast<size_t>(width * format.bytes));
    } else if (format.kind == FormatInfo::Kind::Unorm && format.bytes == 2 * channels) {
        load_unorm16(reinterpret_cast<const std::uint16_t*>(source.texel(0, y, layer)),
                     static_cast<size_t>(width * channels), first);
    } else {
        for (int x = 0; x < width; ++x) {
            const vec4 value = source.load(x, y, layer);
            for (int c = 0; c < channels; ++c) first[x * channels + c] = value[c];
        }
    }
    for (int x = 0; x < reach; ++x)
        for (int c = 0; c < channels; ++c) {
            row[static_cast<size_t>(x * channels + c)] = first[c];
            first[(width + x) * channels + c] = first[(width - 1) * channels + c];
        }
}

void store_row(Target& destination, int y, int layer, const float* row) {
    const FormatInfo& format = info(destination.format());
    if (format.kind == FormatInfo::Kind::Float) {
        std::memcpy(destination.texel(0, y, layer), row, static_cast<size_t>(destination.width() * format.bytes));
        return;
    }
    for (int x = 0; x < destination.width(); ++x) {
        vec4 value(0.0f);
        for (int c = 0; c < format.channels; ++c) value[c] = row[x * format.channels + c];
        destination.store(x, y, layer, value);
    }
}

void count_fragments(PassCounters& counters, std::int64_t fragments, std::int64_t texels, std::int64_t texel_bytes,
                     std::int64_t fragment_bytes) {
    counters.fragments_covered += fragments;
    counters.fragments_passed += fragments;
    counters.fragments_shaded += fragments;
    counters.texels_fetched += texels;
    counters.bytes_read += texels * texel_bytes;
    counters.bytes_written += fragments * fragment_bytes;
}

} // namespace gnomon::detail
