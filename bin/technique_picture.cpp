#include "bin/technique_picture.h"

#include "bin/render_options.h"
#include "core/image_file.h"
#include "eval/bitmap_font.h"

namespace gnomon {
namespace {

constexpr int shrink = 4;
constexpr ivec2 shown(400, 225), rendered = shrink * shown;
constexpr int gap = 4;
constexpr ivec2 crop((600 - shown.x - gap), (shown.y - gap) / 2);
// The foot of the arch and the upper edge of the shadow of the slab, from the left and the bottom.
constexpr ivec2 crop_from(1333, 206);
constexpr vec3 paper(1.0f), background(0.86f), mark(1.0f, 0.3f, 0.0f);

Stage default_stage() {
    SceneRequest request;
    request.scene = "builtin:default";
    return load_stage(request);
}

// Display-referred: even where nothing is wrong, so that every fault of a shadow shows; darker from below than from
// above, so that shapes do.
vec3 plain_color(vec3 albedo, vec3 normal, float visibility) {
    const vec3 linear = albedo * (0.25f + 0.75f * visibility) * (0.75f + 0.25f * normal.y);
    return {srgb_from_linear(linear.x), srgb_from_linear(linear.y), srgb_from_linear(linear.z)};
}

vec3 mean_of_block(const Image<vec3>& image, int x, int y) {
    vec3 sum(0.0f);
    for (int j = 0; j < shrink; ++j)
        for (int i = 0; i < shrink; ++i) sum += image(x * shrink + i, y * shrink + j);
    return sum / static_cast<float>(shrink * shrink);
}

void paste_crop(Image<vec3>& picture, const Image<vec3>& image, int y, const std::string& label) {
    const int x = shown.x + gap;
    for (int j = 0; j < crop.y; ++j)
        for (int i = 0; i < crop.x; ++i) picture(x + i, y + j) = image(crop_from.x + i, crop_from.y + j);
    const int top = y + crop.y - glyph_height - 4;
    for (int j = top - 3; j < y + crop.y; ++j)
        for (int i = 0; i < text_width(label, 1) + 8; ++i) picture(x + i, j) = vec3(0.1f);
    draw_text(picture, x + 4, top, label, paper, 1);
}

void outline(Image<vec3>& picture, ivec2 from, ivec2 size, vec3 color) {
    for (int i = 0; i < size.x; ++i) picture(from.x + i, from.y) = picture(from.x + i, from.y + size.y - 1) = color;
    for (int j = 0; j < size.y; ++j) picture(from.x, from.y + j) = picture(from.x + size.x - 1, from.y + j) = color;
}

} // namespace

TechniquePictures::TechniquePictures()
    : stage_(default_stage()), frame_(stage_.scene, stage_.camera, rendered.x, rendered.y, Primary::Raster) {}

const Image<vec3>& TechniquePictures::shaded(const std::string& specification) {
    const auto [found, is_new] = shaded_.try_emplace(specification, rendered.x, rendered.y, background);
    if (!is_new) return found->second;
    const TechniqueRequest technique = read_technique(specification);
    frame_.begin_technique();
    const Visibility visibility =
        run_technique(*technique.entry, *technique.entry->make(technique.parameters), frame_, stage_.lights.front());
    const GBuffer& gbuffer = frame_.gbuffer();
    Image<vec3>& image = found->second;
    for (int y = 0; y < rendered.y; ++y)
        for (int x = 0; x < rendered.x; ++x)
            if (gbuffer.receivers(x, y).valid())
                image(x, y) = plain_color(gbuffer.albedo(x, y), gbuffer.shading_normal(x, y), visibility.values(x, y));
    return image;
}

Image<vec3> TechniquePictures::draw(const Entry& entry) {
    const std::string& id = entry.info.id;
    const std::string truth = "truth:samples=256",
                      beside = id == "truth"                                                 ? "raytraced"
                               : entry.info.kind == TechniqueKind::Soft || id == "raytraced" ? truth
                                                                                             : "raytraced";
    const Image<vec3>&own = shaded(id == "truth" ? truth : id), &reference = shaded(beside);
    Image<vec3> picture(shown.x + gap + crop.x, shown.y, paper);
    for (int y = 0; y < shown.y; ++y)
        for (int x = 0; x < shown.x; ++x) picture(x, y) = mean_of_block(own, x, y);
    outline(picture, crop_from / shrink - 1, crop / shrink + 2, mark);
    paste_crop(picture, own, crop.y + gap, id);
    paste_crop(picture, reference, 0, beside == truth ? "truth" : beside);
    if (id != "truth" && id != "raytraced") shaded_.erase(id);
    return picture;
}

} // namespace gnomon
