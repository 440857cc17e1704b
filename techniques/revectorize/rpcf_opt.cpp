// Revectorization-based percentage-closer filtering that walks once for neighbouring samples: where a sample shares a
// direction of discontinuity with the one before it, that one's distances, moved along, are its own. [Macedo 2018,
// 4.1.2, algorithm 2]
//
// 1. shadow map.
// 2. filter, per receiver, samples row by row:
//    V_SM (3.2), sides (3.3); none: V_SM, and nothing to reuse for the next.
//    Same side of the silhouette and a direction in common with the sample before [HASSAMEDIRECTION]: its signed
//    distances, less or more what lies between [UPDATERELATIVEPOSITION]; else four traversals.
//    V = Σ V** (4.1), (4.2) / kernel².
//
// As printed the algorithm keeps the previous sample outside the loop over samples, and moves r; it is kept inside, and
// distances are moved, which r' = r ∓ Δ/length comes to but keeps their signs. Two samples may share a direction and
// lie on different runs, so that V differs from rpcf's; samples that share neither row nor column of texels, or that
// a move would carry past the end of the run, walk anew.

#include "techniques/all.h"
#include "techniques/revectorize/rpcf.h"

namespace gnomon {
namespace {

// The distances of a point `delta` texels further on the same run; false where that is past an end.
bool move_along(RunDistances& d, vec2 delta) {
    const auto moved = [](float distance, float by) { return std::copysign(std::abs(distance) + by, distance); };
    if (std::abs(d.x_minus) + delta.x < 0 || std::abs(d.x_plus) - delta.x < 0 || std::abs(d.y_minus) + delta.y < 0 ||
        std::abs(d.y_plus) - delta.y < 0)
        return false;
    d = {moved(d.x_minus, delta.x), moved(d.x_plus, -delta.x), moved(d.y_minus, delta.y), moved(d.y_plus, -delta.y)};
    return true;
}

// The sample before, if it lies on a silhouette.
struct Previous {
    bool valid = false;
    bool lit = true;
    unsigned sides = 0;
    ivec2 texel{0};
    vec2 texels{0.0f};
    RunDistances distances{};
};

class DirectionReuse {
public:
    DirectionReuse(const MapSource& source, const SilhouetteRules& rules, bool flip_isolated)
        : silhouette_(source, rules), rules_(rules), flip_isolated_(flip_isolated) {}

    void add(KernelSum& sum, const MapSample& sample) {
        const SilhouettePoint p = silhouette_.point(sample);
        const unsigned sides = silhouette_.discontinuities(p.place, p.depth, p.lit);
        if (sides == 0 || (flip_isolated_ && sides == all_sides)) {
            previous_.valid = false;
            sum.add({p.lit == (sides == 0) ? 1.0f : 0.0f, p.lit, sides, vec2(0.0f)}, false);
            return;
        }
        const bool same_line = p.place.texel.x == previous_.texel.x || p.place.texel.y == previous_.texel.y;
        const bool reuse = previous_.valid && p.lit == previous_.lit && (sides & previous_.sides) != 0 && same_line &&
                           move_along(previous_.distances, sample.texels - previous_.texels);
        const RunDistances distances = reuse ? previous_.distances : silhouette_.distances(p, sides);
        previous_ = {true, p.lit, sides, p.place.texel, sample.texels, distances};
        const vec2 r = signed_relative_position(distances, rules_.max_size);
        sum.add({filtered_visibility(r, p.lit), p.lit, sides, r}, !reuse);
    }

private:
    Silhouette<MapSource> silhouette_;
    const SilhouetteRules& rules_;
    bool flip_isolated_;
    Previous previous_;
};

class RpcfOpt : public Technique {
public:
    explicit RpcfOpt(RpcfParams params) : params_(params) {}

    Visibility shade(Frame& frame, const Light& light) override {
        return filter_receivers(
            frame, light, params_,
            [&](const MapSource& source, const SilhouetteRules& rules, const MapSample& centre,
                const std::vector<float>& offsets) {
                DirectionReuse samples(source, rules, params_.flip_isolated);
                KernelSum sum;
                for (const float v : offsets)
                    for (const float u : offsets)
                        samples.add(sum, {centre.texels + vec2(u, v), centre.depth, centre.slope_eps});
                return sum;
            });
    }

private:
    RpcfParams params_;
};

} // namespace

Entry rpcf_opt_entry() {
    return make_entry<RpcfOpt, RpcfParams>(
        {.id = "rpcf-opt",
         .title = "revectorization-based percentage-closer filtering, reusing directions",
         .family = "revectorization",
         .kind = TechniqueKind::Filtered,
         .paper = "Macedo 2018",
         .lights = all_lights,
         .section = "Macedo 2018, 4.1.2, algorithm 2",
         .equations = "(3.1) to (3.4), (4.1) as its text has it, (4.2)",
         .strengths = "rpcf with a fraction of its traversals",
         .artifacts = "differs from rpcf where two runs share a direction; else as rpcf"},
        rpcf_fields);
}

} // namespace gnomon
