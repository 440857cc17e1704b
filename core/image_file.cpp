#include "core/image_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <new>

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include "core/atomic_file.h"
#include "core/error.h"

namespace gnomon {
namespace {

constexpr int rows_at_a_time = 64; // bounds the interleaved copy; a multiple of ZIP's 16-row blocks

std::string first_line(const std::string& text) { return text.substr(0, text.find_first_of("\r\n")); }

// OpenImageIO's sentence about what went wrong, without the name of a temporary file in it.
std::string reason(const std::string& message, const std::string& hidden_path) {
    std::string line = first_line(message.empty() ? OIIO::geterror() : message);
    for (const std::string& hidden : {"\"" + hidden_path + "\"", "'" + hidden_path + "'", hidden_path})
        for (size_t at; !hidden_path.empty() && (at = line.find(hidden)) != std::string::npos;)
            line.replace(at, hidden.size(), "the file");
    return line.empty() ? "no reason given" : line;
}

// Distributions build OpenImageIO with its debugging messages on; standard error is ours alone.
void quieten_library() {
    static const bool done = OIIO::attribute("debug", 0);
    (void)done;
}

[[noreturn]] void fail_to_write(const std::string& path, const std::string& why) {
    throw InputError(fmt::format("cannot write '{}': {}", path, why));
}

[[noreturn]] void fail_to_read(const std::string& path, const std::string& why) {
    throw InputError(fmt::format("cannot read '{}': {}", path, why));
}

// Writes `rows(first, count)`, interleaved samples of `format` of file rows [first, first + count), top row first.
// `shown` names the file in errors, `opened` is what the library opens: another path, or a name for what lies in
// memory.
template <class Rows>
void write_rows(const std::string& shown, const std::string& opened, const OIIO::ImageSpec& spec, OIIO::TypeDesc format,
                const char* driver, Rows rows) {
    const std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create(driver);
    if (!output) fail_to_write(shown, reason("", opened));
    if (!output->open(opened, spec)) fail_to_write(shown, reason(output->geterror(), opened));
    for (int first = 0; first < spec.height; first += rows_at_a_time) {
        const int count = std::min(rows_at_a_time, spec.height - first);
        const auto samples = rows(first, count);
        if (!output->write_scanlines(first, first + count, 0, format, samples.data()))
            fail_to_write(shown, reason(output->geterror(), opened));
    }
    if (!output->close()) fail_to_write(shown, reason(output->geterror(), opened));
}

void put_attribute(OIIO::ImageSpec& spec, const std::string& name, const Attribute& value) {
    if (const auto* text = std::get_if<std::string>(&value)) spec.attribute(name, *text);
    if (const auto* number = std::get_if<float>(&value)) spec.attribute(name, *number);
    if (const auto* whole = std::get_if<int>(&value)) spec.attribute(name, *whole);
    // GLM's column-major matrices for column vectors are, in memory, EXR's row-major matrices for row vectors.
    if (const auto* matrix = std::get_if<mat4>(&value)) spec.attribute(name, OIIO::TypeMatrix44, &(*matrix)[0][0]);
}

std::map<std::string, Attribute> attributes_of(const OIIO::ImageSpec& spec) {
    // OpenImageIO renames these of EXR's common attributes on reading (the last from version 2.5).
    const std::map<std::string, std::string> exr_names = {
        {"worldtocamera", "worldToCamera"}, {"worldtoscreen", "worldToNDC"}, {"worldtoNDC", "worldToNDC"}};
    std::map<std::string, Attribute> attributes;
    for (const OIIO::ParamValue& parameter : spec.extra_attribs) {
        std::string name = parameter.name().string();
        if (const auto renamed = exr_names.find(name); renamed != exr_names.end()) name = renamed->second;
        if (parameter.type() == OIIO::TypeString) attributes[name] = parameter.get_string();
        if (parameter.type() == OIIO::TypeFloat) attributes[name] = parameter.get_float();
        if (parameter.type() == OIIO::TypeInt) attributes[name] = parameter.get_int();
        if (parameter.type() == OIIO::TypeMatrix44) {
            mat4 matrix;
            std::copy_n(static_cast<const float*>(parameter.data()), 16, &matrix[0][0]);
            attributes[name] = matrix;
        }
    }
    return attributes;
}

// A broken header can claim far more pixels than the file could hold; believing it would exhaust the memory.
bool claims_too_much(const OIIO::ImageSpec& spec, const std::string& path) {
    constexpr std::uintmax_t believed = std::uintmax_t{1} << 30, largest_compression_ratio = 4096;
    const std::uintmax_t claimed = spec.image_bytes(true);
    std::error_code error;
    const std::uintmax_t stored = std::filesystem::file_size(path, error);
    return !error && claimed > believed && claimed / largest_compression_ratio > stored;
}

// libpng prints a line of its own about a file that ends early, so that is found out before it sees the file: a PNG is
// a signature and a row of chunks (length, type, data, checksum), the last of which is IEND.
void check_png_is_whole(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::array<unsigned char, 8> head{};
    const auto next_eight = [&] { return static_cast<bool>(file.read(reinterpret_cast<char*>(head.data()), 8)); };
    constexpr std::array<unsigned char, 8> signature = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    if (!next_eight() || head != signature) return;
    while (next_eight()) {
        const auto length = static_cast<std::streamoff>(head[0]) << 24 | head[1] << 16 | head[2] << 8 | head[3];
        if (std::equal(head.begin() + 4, head.end(), "IEND")) return;
        file.seekg(length + 4, std::ios::cur);
    }
    fail_to_read(path, "the file is truncated");
}

void check_header(const OIIO::ImageSpec& spec, const std::string& path) {
    if (spec.deep) fail_to_read(path, "deep images have no single value per pixel");
    if (spec.width < 1 || spec.height < 1 || spec.depth > 1 || spec.nchannels < 1)
        fail_to_read(path, "it holds no two-dimensional image");
    if (spec.width > max_image_side || spec.height > max_image_side)
        fail_to_read(path, fmt::format("it is {}x{}, but each side may be at most {} pixels", spec.width, spec.height,
                                       max_image_side));
    if (claims_too_much(spec, path))
        fail_to_read(path, fmt::format("its header promises {}x{} pixels of {} channels, more than it can hold",
                                       spec.width, spec.height, spec.nchannels));
}

// A run of channels, read row by row as they are stored or as floats, and what to do with each sample.
template <class T, class Put>
void read_samples(OIIO::ImageInput& input, const OIIO::ImageSpec& spec, const std::string& path, int first_channel,
                  int end_channel, OIIO::TypeDesc type, Put put) {
    const auto channels = static_cast<size_t>(end_channel - first_channel), width = static_cast<size_t>(spec.width);
    const int step = spec.tile_width > 0 ? spec.height : std::min(rows_at_a_time, spec.height); // tiles: all at once
    std::vector<T> samples(channels * width * static_cast<size_t>(step));
    for (int first = 0; first < spec.height; first += step) {
        const int count = std::min(step, spec.height - first);
        const bool read = spec.tile_width > 0
                              ? input.read_image(0, 0, first_channel, end_channel, type, samples.data())
                              : input.read_scanlines(0, 0, spec.y + first, spec.y + first + count, spec.z,
                                                     first_channel, end_channel, type, samples.data());
        if (!read) fail_to_read(path, reason(input.geterror(), path) + "; the file is truncated or broken");
        for (size_t c = 0; c < channels; ++c)
            for (int y = 0; y < count; ++y)
                put(static_cast<size_t>(first_channel) + c, spec.height - 1 - (first + y),
                    samples.data() + static_cast<size_t>(y) * width * channels + c, channels);
    }
}

// The whole numbers of an EXR are ids and counts, not fractions of the largest one.
bool is_whole_number(const OIIO::ImageInput& input, const OIIO::ImageSpec& spec, int channel) {
    return std::string(input.format_name()) == "openexr" && spec.channelformat(channel) == OIIO::TypeUInt32;
}

void read_channels(OIIO::ImageInput& input, const OIIO::ImageSpec& spec, const std::string& path, ChannelImage& image) {
    const auto put = [&](size_t channel, int y, const auto* sample, size_t stride) {
        const std::span<float> row = image.channels[channel].values.row(y);
        for (size_t x = 0; x < row.size(); ++x) row[x] = static_cast<float>(sample[x * stride]);
    };
    read_samples<float>(input, spec, path, 0, spec.nchannels, OIIO::TypeFloat, put);
    for (int c = 0; c < spec.nchannels; ++c)
        if (is_whole_number(input, spec, c))
            read_samples<std::uint32_t>(input, spec, path, c, c + 1, OIIO::TypeUInt32, put);
}

} // namespace

const Channel* ChannelImage::find(const std::string& name) const {
    const auto found = std::find_if(channels.begin(), channels.end(), [&](const Channel& c) { return c.name == name; });
    return found == channels.end() ? nullptr : &*found;
}

void ChannelImage::add(const std::string& name, Image<float> values, bool half) {
    if (channels.empty()) width = values.width(), height = values.height();
    assert(values.width() == width && values.height() == height && !find(name));
    channels.push_back({name, std::move(values), half});
}

namespace {

Image<float> component(const Image<vec3>& vectors, int index) {
    Image<float> values(vectors.width(), vectors.height());
    for (size_t i = 0; i < values.size(); ++i) values.values()[i] = vectors.values()[i][index];
    return values;
}

} // namespace

void ChannelImage::add_color(const std::string& prefix, const Image<vec3>& color, bool half) {
    const std::string dot = prefix.empty() ? "" : prefix + ".";
    for (int i = 0; i < 3; ++i) add(dot + "RGB"[i], component(color, i), half);
}

void ChannelImage::add_vector(const std::string& prefix, const Image<vec3>& vector) {
    const std::string dot = prefix.empty() ? "" : prefix + ".";
    for (int i = 0; i < 3; ++i) add(dot + "XYZ"[i], component(vector, i));
}

void write_exr(const std::string& path, const ChannelImage& image) {
    if (image.channels.empty()) throw InputError(fmt::format("cannot write '{}': the image has no channels", path));
    OIIO::ImageSpec spec(image.width, image.height, static_cast<int>(image.channels.size()), OIIO::TypeFloat);
    for (size_t c = 0; c < image.channels.size(); ++c) {
        spec.channelnames[c] = image.channels[c].name;
        spec.channelformats.push_back(image.channels[c].half ? OIIO::TypeHalf : OIIO::TypeFloat);
    }
    for (const auto& [name, value] : image.attributes) put_attribute(spec, name, value);
    spec.attribute("compression", "zip");
    // Without a date OpenImageIO writes the present one; an attribute of a type that EXR lacks keeps it from writing
    // any.
    const void* nothing = nullptr;
    spec.attribute("DateTime", OIIO::TypeDesc(OIIO::TypeDesc::PTR), &nothing);
    const auto rows = [&](int first, int count) {
        std::vector<float> samples;
        samples.reserve(static_cast<size_t>(count) * static_cast<size_t>(image.width) * image.channels.size());
        for (int y = first; y < first + count; ++y)
            for (int x = 0; x < image.width; ++x)
                for (const Channel& channel : image.channels)
                    samples.push_back(channel.values(x, image.height - 1 - y));
        return samples;
    };
    quieten_library();
    write_atomically(path, [&](const std::string& temporary_path) {
        write_rows(path, temporary_path, spec, OIIO::TypeFloat, "openexr", rows);
    });
}

namespace {

// Interleaved 8-bit rows for write_rows; NaN becomes 0.
auto quantized_rows(const Image<vec3>& srgb) {
    return [&srgb](int first, int count) {
        const auto quantize = [](float value) {
            return static_cast<std::uint8_t>(value > 0.0f ? std::min(value, 1.0f) * 255.0f + 0.5f : 0.0f);
        };
        std::vector<std::uint8_t> samples;
        samples.reserve(static_cast<size_t>(count) * static_cast<size_t>(srgb.width()) * 3);
        for (int y = first; y < first + count; ++y)
            for (const vec3& color : srgb.row(srgb.height() - 1 - y))
                for (int i = 0; i < 3; ++i) samples.push_back(quantize(color[i]));
        return samples;
    };
}

template <class Rows> std::string encode_rows(int width, int height, int channels, Rows rows) {
    OIIO::ImageSpec spec(width, height, channels, OIIO::TypeUInt8);
    spec.attribute("oiio:ColorSpace", "sRGB");
    // On rendered images level 9 takes fifteen times as long for a tenth less, and differences to the left neighbour
    // alone (PNG_FILTER_SUB) beat libpng's choice of filters by a fifth.
    spec.attribute("png:compressionLevel", 6);
    spec.attribute("png:filter", 0x10);
    OIIO::Filesystem::IOVecOutput bytes;
    void* const destination = &bytes;
    spec.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &destination);
    quieten_library();
    write_rows("a PNG in memory", "memory.png", spec, OIIO::TypeUInt8, "png", rows);
    return {bytes.buffer().begin(), bytes.buffer().end()};
}

} // namespace

void write_png(const std::string& path, const Image<vec3>& srgb, const std::map<std::string, std::string>& text) {
    OIIO::ImageSpec spec(srgb.width(), srgb.height(), 3, OIIO::TypeUInt8);
    for (const auto& [name, value] : text) spec.attribute(name, value);
    spec.attribute("oiio:ColorSpace", "sRGB");
    quieten_library();
    write_atomically(path, [&](const std::string& temporary_path) {
        write_rows(path, temporary_path, spec, OIIO::TypeUInt8, "png", quantized_rows(srgb));
    });
}

std::string encode_png(const Image<vec3>& srgb) {
    return encode_rows(srgb.width(), srgb.height(), 3, quantized_rows(srgb));
}

std::string encode_png(const Image<std::uint8_t>& gray) {
    return encode_rows(gray.width(), gray.height(), 1, [&](int first, int count) {
        std::vector<std::uint8_t> samples;
        for (int y = first; y < first + count; ++y) {
            const std::span<const std::uint8_t> row = gray.row(gray.height() - 1 - y);
            samples.insert(samples.end(), row.begin(), row.end());
        }
        return samples;
    });
}

ChannelImage read_image(const std::string& path) {
    std::error_code ignored;
    if (!std::filesystem::exists(path, ignored)) fail_to_read(path, "there is no such file");
    if (std::filesystem::is_directory(path, ignored)) fail_to_read(path, "it is a folder");
    quieten_library();
    check_png_is_whole(path);
    try {
        OIIO::ImageSpec as_stored;
        as_stored.attribute("oiio:UnassociatedAlpha", 1); // colours stay as stored, not multiplied by alpha
        const std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::open(path, &as_stored);
        if (!input) fail_to_read(path, reason("", path));
        const OIIO::ImageSpec spec = input->spec();
        check_header(spec, path);
        if (input->seek_subimage(1, 0))
            fail_to_read(path,
                         "it holds several images; take out the one you mean, for example by oiiotool --subimage");
        input->seek_subimage(0, 0);
        (void)input->geterror(); // that there is no second image is no failure
        ChannelImage image;
        image.attributes = attributes_of(spec);
        image.width = spec.width, image.height = spec.height;
        for (int c = 0; c < spec.nchannels; ++c)
            image.channels.push_back(
                {spec.channel_name(c), Image<float>(spec.width, spec.height), spec.channelformat(c) == OIIO::TypeHalf});
        read_channels(*input, spec, path, image);
        return image;
    } catch (const Error&) {
        throw;
    } catch (const std::bad_alloc&) {
        fail_to_read(path, "it does not fit in memory");
    } catch (const std::exception& error) { // a decoder's own exception must not end the program
        fail_to_read(path, reason(error.what(), path));
    }
}

float srgb_from_linear(float linear) {
    return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1.0f / 2.4f) - 0.055f;
}

float linear_from_srgb(float srgb) {
    return srgb <= 0.04045f ? srgb / 12.92f : std::pow((srgb + 0.055f) / 1.055f, 2.4f);
}

} // namespace gnomon
