// Coverage by sample, for as many samples as the witness has: each sample keeps the last triangle that covers it, and a
// resolve takes the mean of the samples' colours.

#include <array>

#define GL_GLEXT_PROTOTYPES
#include <GL/glcorearb.h>
#include <fmt/format.h>

#include "raster/passes/resolve.h"
#include "tests/conformance/triangles.h"

namespace gnomon_conformance {
namespace {

constexpr int side = 256;

const char* const vertex_source = R"(#version 450 core
layout(location = 0) in vec4 position;
void main() { gl_Position = position; })";
const char* const fragment_source = R"(#version 450 core
layout(location = 0) out uint id;
layout(location = 1) out vec4 color;
void main() {
    id = uint(gl_PrimitiveID);
    color = vec4(float(gl_PrimitiveID & 7), float(gl_PrimitiveID >> 3 & 7), float(gl_PrimitiveID >> 6 & 7), 8.0) / 8.0;
})";
const char* const sample_source = R"(#version 450 core
layout(binding = 0) uniform usampler2DMS ids;
uniform float chosen;
layout(location = 0) out uint id;
void main() { id = texelFetch(ids, ivec2(gl_FragCoord.xy), int(chosen)).x; })";

vec4 color_of(std::uint32_t id) {
    return vec4(static_cast<float>(id & 7), static_cast<float>(id >> 3 & 7), static_cast<float>(id >> 6 & 7), 8.0f) /
           8.0f;
}

// The same batch into both, and what each sample shows.
class MultisampledDuel {
public:
    explicit MultisampledDuel(int samples)
        : samples_(samples), ids_(Format::R32UI, side, side, samples), color_(Format::RGBA32F, side, side, samples),
          resolved_(Format::RGBA32F, side, side), multi_({.width = side,
                                                          .height = side,
                                                          .depth = std::nullopt,
                                                          .color = {Format::R32UI, Format::RGBA32F},
                                                          .samples = samples}),
          single_({.width = side, .height = side, .depth = std::nullopt, .color = {Format::R32UI, Format::RGBA32F}}),
          program_(vertex_source, fragment_source), sample_program_(gnomon_gl::screen_vertex_source, sample_source) {}

    void draw(const Batch& batch, const PipelineState& state) {
        Pass pass(log_, "duel");
        ids_.clear_uint(pass, no_id);
        color_.clear(pass, vec4(0.0f));
        gnomon::draw(
            pass, {static_cast<std::uint32_t>(batch.positions.size()), batch.triangles}, state,
            [&](std::uint32_t i) { return batch.positions[i]; },
            [&](const Fragment<NoVaryings>& in, FragmentOutput& out) {
                out.color[0].x = glm::uintBitsToFloat(in.primitive);
                out.color[1] = color_of(in.primitive);
            },
            Targets{.color = {&ids_, &color_}, .samples = samples_});
        resolve_samples(pass, color_, resolved_, samples_);

        multi_.bind();
        multi_.clear_uint(0, no_id);
        multi_.clear_color(1, vec4(0.0f));
        gnomon_gl::set_state(state, side, side);
        program_.use();
        gnomon_gl::Mesh(batch.positions, batch.triangles).draw();
        multi_.resolve_color(1, single_);
    }

    std::vector<std::uint32_t> witness_ids(int sample) const {
        const std::array<GLenum, 2> both = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
        single_.bind();
        glDrawBuffers(1, both.data());
        PipelineState state;
        gnomon_gl::set_state(state, side, side);
        multi_.bind_color_texture(0, 0);
        sample_program_.set("chosen", static_cast<float>(sample));
        sample_program_.set("z", 0.0f);
        sample_program_.use();
        screen_.draw();
        return single_.uints(0);
    }
    std::vector<vec4> witness_means() const { return single_.colors(1); }
    std::uint32_t id(int x, int y, int sample) const { return ids_.load_uint(x, y, sample).x; }
    vec4 mean(int x, int y) const { return resolved_.load(x, y); }
    const PassCounters& counters() const { return log_.passes.back(); }

private:
    int samples_;
    PassLog log_;
    Target ids_, color_, resolved_;
    gnomon_gl::Framebuffer multi_, single_;
    gnomon_gl::Program program_, sample_program_;
    gnomon_gl::Screen screen_;
};

} // namespace

bool check_multisampling(const Options& options) {
    Verdict verdict("multisampling");
    GLint most = 0, most_integer = 0;
    glGetIntegerv(GL_MAX_COLOR_TEXTURE_SAMPLES, &most);
    glGetIntegerv(GL_MAX_INTEGER_SAMPLES, &most_integer);
    for (const int samples : {4, 8}) {
        if (samples > std::min(most, most_integer)) {
            verdict.skip(fmt::format("{} samples: the other side has {}", samples, std::min(most, most_integer)));
            continue;
        }
        Random random(options.seed + 9);
        MultisampledDuel duel(samples);
        std::int64_t shown = 0, ids = 0, means = 0, triangles = 0;
        for (int i = 0; i < options.repeat(60); ++i) {
            const Batch batch = random_batch(512, {.width = side, .height = side, .snapped = random.chance(2)}, random);
            PipelineState state;
            state.viewport = wide_viewport(side, side);
            duel.draw(batch, state);
            triangles += static_cast<std::int64_t>(batch.triangles.size());
            const std::vector<vec4> theirs = duel.witness_means(); // before single_ takes ids
            for (int y = 0; y < side; ++y)
                for (int x = 0; x < side; ++x) means += duel.mean(x, y) != theirs[static_cast<size_t>(y * side + x)];
            for (int s = 0; s < samples; ++s) {
                const std::vector<std::uint32_t> theirs_of_sample = duel.witness_ids(s);
                for (int y = 0; y < side; ++y)
                    for (int x = 0; x < side; ++x) {
                        const std::uint32_t ours = duel.id(x, y, s);
                        shown += ours != no_id;
                        ids += ours != theirs_of_sample[static_cast<size_t>(y * side + x)];
                    }
            }
        }
        verdict.require(ids == 0 && means == 0,
                        fmt::format("{} samples: {} triangles, {} samples that show one; {} differ, and {} means",
                                    samples, triangles, shown, ids, means));
    }
    return verdict.held();
}

} // namespace gnomon_conformance
