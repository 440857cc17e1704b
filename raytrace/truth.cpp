#include "raytrace/truth.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <optional>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/interrupt.h"
#include "core/parallel.h"
#include "core/progress.h"
#include "raytrace/error_bar.h"
#include "raytrace/occlusion.h"
#include "raytrace/truth_state.h"

namespace gnomon {
namespace {

// Sample positions of one receiver and which of them it sees; one a thread and tile.
struct Scratch {
    std::vector<float> u, v, x, y, z;
    std::vector<std::uint16_t> seen;
    void resize(size_t count) {
        for (std::vector<float>* values : {&u, &v, &x, &y, &z}) values->resize(count);
        seen.resize(seen_words(count));
    }
};

// The samples of a sequence are traced up to 1024, 4096, 16384, … or, where pixels may stop, from 64 on, and those of a
// stage are packed among themselves: the more, the nearer the rays of a packet are to each other. Which samples share a
// packet is then the same whether a run stopped between stages or not: what Embree rounds may depend on a ray's
// company.
std::vector<std::uint32_t> stage_counts(const TruthSettings& settings) {
    std::vector<std::uint32_t> counts;
    const auto samples = static_cast<std::uint32_t>(settings.samples);
    if (is_sequence(settings.pattern))
        for (std::uint32_t count = settings.target_error > 0 ? 64 : 1024; count < samples; count *= 4)
            counts.push_back(count);
    counts.push_back(samples);
    return counts;
}

// The pattern by stages.
struct Stages {
    std::vector<std::uint32_t> counts;  // samples at the end of each
    std::vector<PreparedPattern> steps; // the samples that each adds
    std::vector<PreparedPattern> whole; // all up to its end; empty where nobody asks before the last
};

Stages prepare_stages(const TruthSettings& settings) {
    Stages prepared{stage_counts(settings), {}, {}};
    int first = 0;
    for (const std::uint32_t count : prepared.counts) {
        const int samples = static_cast<int>(count);
        const bool asked = settings.target_error > 0 || count == prepared.counts.back();
        prepared.steps.push_back(prepare_pattern(settings.pattern, samples, SampleOrder::Packed, first));
        prepared.whole.push_back(asked ? prepare_pattern(settings.pattern, samples, SampleOrder::Packed)
                                       : PreparedPattern{});
        first = samples;
    }
    return prepared;
}

// Cuts what an earlier run traced back to whole stages. The last is cut short by the number of samples, so only the
// same number will do.
void keep_stages(SampleBits& bits, std::span<const std::uint32_t> counts) {
    std::uint32_t kept = 0;
    for (const std::uint32_t count : counts)
        if (count == counts.back() ? count == bits.samples() : count <= bits.samples()) kept = count;
    bits.truncate(kept);
}

struct Job {
    const EmbreeScene& scene;
    const Receivers& receivers;
    const Light& light;
    const Light local_light; // in the scene's local coordinates, as all that is traced
    const TruthSettings settings;
    const TruthRun& run;
    const Stages stages;
    TruthAnswer answer;
    std::atomic<std::int64_t> rays{0}; // a sum of integers: the same in any order

    Receiver local(int x, int y) const { return to_local(receivers(x, y), scene.shift()); }
    void tile(size_t index);
    std::int64_t settle(Scratch& scratch, Occlusion& occlusion, int x, int y, SampleBits& bits);
    std::int64_t trace(Scratch& scratch, Occlusion& occlusion, const Receiver& receiver, std::uint32_t pixel,
                       SampleBits& bits, const PreparedPattern& samples);
    vec3 radiance(Scratch& scratch, const Surface& surface, std::uint32_t pixel, const SampleBits& bits,
                  const PreparedPattern& samples);
};

std::int64_t Job::trace(Scratch& scratch, Occlusion& occlusion, const Receiver& receiver, std::uint32_t pixel,
                        SampleBits& bits, const PreparedPattern& samples) {
    scratch.resize(samples.size());
    // Where all points are alike it does not matter which they are.
    if (occlusion.prove(receiver) == Occlusion::Proof::None) {
        fill_pattern(samples, pixel, settings.seed, scratch.u, scratch.v);
        light_points(local_light, receiver.position, scratch.u, scratch.v, scratch.x, scratch.y, scratch.z);
    }
    const std::int64_t traced = occlusion.seen(receiver, {scratch.x, scratch.y, scratch.z}, scratch.seen).rays;
    bits.append(samples.index, scratch.seen);
    return traced;
}

vec3 Job::radiance(Scratch& scratch, const Surface& surface, std::uint32_t pixel, const SampleBits& bits,
                   const PreparedPattern& samples) {
    if (bits.seen() == 0 || !is_area(light)) return reflected_radiance(settings.brdf, surface, light, {}, {}, {}, bits);
    scratch.resize(samples.size());
    fill_pattern(samples, pixel, settings.seed, scratch.u, scratch.v);
    return reflected_radiance(settings.brdf, surface, light, scratch.u, scratch.v, samples.index, bits);
}

// One pixel, from whatever samples it has to its answer; returns the rays traced. The answer is a function of the first
// samples of the sequence alone, so it is the same whether they were traced now or earlier.
std::int64_t Job::settle(Scratch& scratch, Occlusion& occlusion, int x, int y, SampleBits& bits) {
    const Receiver receiver = local(x, y);
    const auto pixel = static_cast<std::uint32_t>(y * receivers.width() + x);
    std::int64_t traced = 0;
    for (size_t stage = 0; stage < stages.counts.size(); ++stage) {
        const std::uint32_t samples = stages.counts[stage];
        if (bits.samples() < samples) traced += trace(scratch, occlusion, receiver, pixel, bits, stages.steps[stage]);
        const bool last = samples == stages.counts.back();
        if (!last && settings.target_error <= 0.0f) continue;
        const PreparedPattern& whole = stages.whole[stage];
        const float error = is_area(light) ? error_bar(whole, bits) : 0.0f;
        if (!last && error > settings.target_error) continue;
        answer.visibility(x, y) = static_cast<float>(bits.seen_of(samples)) / static_cast<float>(samples);
        answer.error(x, y) = error;
        answer.samples(x, y) = static_cast<float>(samples);
        if (answer.radiance) (*answer.radiance)(x, y) = radiance(scratch, settings.surface(x, y), pixel, bits, whole);
        break;
    }
    return traced;
}

// The blocks of a tile, made when first asked for.
class Blocks {
public:
    Blocks(const Job& job, int left, int bottom, int right, int top)
        : job_(job), left_(left), bottom_(bottom), right_(right), top_(top) {}

    Occlusion& at(int x, int y) {
        const int column = (x - left_) / block_side, row = (y - bottom_) / block_side;
        const int index = row * per_side + column;
        std::optional<Occlusion>& block = blocks_[static_cast<size_t>(index)];
        if (!block) {
            const int left = left_ + column * block_side, bottom = bottom_ + row * block_side;
            std::vector<Receiver> receivers;
            for (int j = bottom; j < std::min(bottom + block_side, top_); ++j)
                for (int i = left; i < std::min(left + block_side, right_); ++i) receivers.push_back(job_.local(i, j));
            block.emplace(job_.scene, job_.local_light, receivers, static_cast<size_t>(job_.settings.samples),
                          job_.run.clusters);
        }
        return *block;
    }

private:
    static constexpr int block_side = 8, per_side = truth_tile_side / block_side;
    const Job& job_;
    int left_, bottom_, right_, top_;
    std::array<std::optional<Occlusion>, per_side * per_side> blocks_;
};

void Job::tile(size_t index) {
    const size_t across = static_cast<size_t>(truth_tiles_across(receivers.width()));
    const int left = static_cast<int>(index % across) * truth_tile_side,
              bottom = static_cast<int>(index / across) * truth_tile_side;
    const int right = std::min(left + truth_tile_side, receivers.width()),
              top = std::min(bottom + truth_tile_side, receivers.height());
    if (run.share.has(index)) {
        size_t pixels = 0;
        for (int y = bottom; y < top; ++y)
            for (int x = left; x < right; ++x) pixels += receivers(x, y).valid();
        Blocks blocks(*this, left, bottom, right, top);
        std::vector<SampleBits> bits(pixels);
        const bool known = run.state && run.state->load(run.light_index, index, bits);
        for (SampleBits& pixel_bits : bits) keep_stages(pixel_bits, stages.counts);
        bool more = !known;
        Scratch scratch;
        std::int64_t traced = 0;
        size_t i = 0;
        for (int y = bottom; y < top; ++y)
            for (int x = left; x < right; ++x) {
                if (!receivers(x, y).valid()) continue;
                const std::uint32_t before = bits[i].samples();
                traced += settle(scratch, blocks.at(x, y), x, y, bits[i]);
                more |= bits[i++].samples() > before;
            }
        rays += traced;
        if (run.state && more) run.state->store(run.light_index, index, bits);
        if (run.progress && !more) run.progress->skip((right - left) * (top - bottom));
        if (run.progress && !more) return;
    }
    if (run.progress) run.progress->advance((right - left) * (top - bottom));
}

void check(const TruthSettings& settings) {
    if (settings.target_error > 0 && !is_sequence(settings.pattern))
        throw UsageError("a target error needs a pattern whose samples can be added to: sobol, halton, poisson or "
                         "random, not stratified or grid");
}

} // namespace

TruthAnswer area_truth(const EmbreeScene& scene, const Receivers& receivers, const Light& light,
                       const TruthSettings& settings, const TruthRun& run) {
    check(settings);
    TruthSettings own = settings;
    if (!is_area(light)) own.samples = 1, own.target_error = 0;
    Job job{scene, receivers, light, to_local(light, scene.shift()), own, run, prepare_stages(own), {}};
    const int width = receivers.width(), height = receivers.height();
    job.answer.visibility = Image<float>(width, height, 1.0f);
    job.answer.error = Image<float>(width, height, 0.0f);
    job.answer.samples = Image<float>(width, height, 0.0f);
    if (own.surface) job.answer.radiance = Image<vec3>(width, height, vec3(0.0f));
    const size_t tiles =
        static_cast<size_t>(truth_tiles_across(width)) * static_cast<size_t>(truth_tiles_across(height));
    const auto one_tile = [&](size_t index, size_t) {
        if (run.state && pending_interrupt() != 0) return;
        job.tile(index);
    };
    parallel_for(tiles, 1, one_tile, FloatMode::FlushZero);
    if (run.state && pending_interrupt() != 0) run.state->save_and_stop(pending_interrupt());
    job.answer.rays = job.rays;
    return std::move(job.answer);
}

Image<float> area_visibility(const EmbreeScene& scene, const Receivers& receivers, const Light& light, Pattern pattern,
                             int samples, std::uint32_t seed, Progress* progress, const TriangleClusters* clusters) {
    TruthSettings settings;
    settings.pattern = pattern;
    settings.samples = samples;
    settings.seed = seed;
    TruthRun run;
    run.progress = progress;
    run.clusters = clusters;
    return area_truth(scene, receivers, light, settings, run).visibility;
}

TruthAnswer hard_truth(const EmbreeScene& scene, const Receivers& receivers, const Light& light) {
    Light center;
    center.type = light.type == LightType::Directional ? LightType::Directional : LightType::Point;
    center.position = light.position;
    center.direction = light.direction;
    return area_truth(scene, receivers, center, {});
}

} // namespace gnomon
