#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raytrace/silhouettes.cpp" // this file is compiled once for each target
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#include <hwy/foreach_target.h>

#include <algorithm>

#include "raytrace/silhouettes.h"
#include "raytrace/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gnomon::HWY_NAMESPACE {

constexpr float u = 0x1p-24f;

// Triangles seen from the centre of the block's origins.
struct Seen {
    Vector v[3], normal;
    Float edge, distance; // lengths: of the longest edge, and to the farthest corner from any of the origins
    Float low, high;      // heights of the corners over any of the origins, in metres
};

HWY_INLINE Seen look_at(const BlockView& view, const TriangleCluster& cluster, std::size_t first) {
    Seen seen;
    const Vector center = set(view.center), up = set(view.up);
    Float farthest = hn::Zero(d), low = hn::Set(d, infinity), high = hn::Set(d, -infinity);
    for (int k = 0; k < 3; ++k) {
        seen.v[k] = Vector{hn::Load(d, cluster.corner[k][0] + first), hn::Load(d, cluster.corner[k][1] + first),
                           hn::Load(d, cluster.corner[k][2] + first)} -
                    center;
        farthest = hn::Max(farthest, dot(seen.v[k], seen.v[k]));
        const Float height = dot(seen.v[k], up);
        low = hn::Min(low, height), high = hn::Max(high, height);
    }
    const Vector e0 = seen.v[1] - seen.v[0], e1 = seen.v[2] - seen.v[0], e2 = e1 - e0;
    seen.normal = cross(e0, e1);
    seen.edge = hn::Sqrt(hn::Max(hn::Max(dot(e0, e0), dot(e1, e1)), dot(e2, e2)));
    const Vector half = set(view.half);
    seen.distance = hn::Add(hn::Sqrt(farthest), hn::Sqrt(dot(half, half)));
    const Float spread = hn::MulAdd(hn::Set(d, 16 * u), seen.distance, dot(magnitudes(up), half));
    seen.low = hn::Sub(low, spread), seen.high = hn::Add(high, spread);
    return seen;
}

// R + 2 E: corners are rounded by u R, edges by 2 u R, n by 4 u E R + 4 u E², and products by a few u of their own.
HWY_INLINE Float reach_of(const Seen& seen) { return hn::MulAdd(hn::Set(d, 2.0f), seen.edge, seen.distance); }

// How large |V| has to be for a triangle to be clear; E its longest edge, R its distance, H the way to the light's
// plane, all h between `low` and `high`:
// - 2 ω ≤ 1/2 with μ ≤ u E (18 R + 4 E) |d|: an edge function is off by 9 u |e| |v_i + v_j| |d| (see occluders.cpp)
// with
//   |v_i + v_j| ≤ 2 R, and Embree tolerates 2 u of the functions' sum, which is 2 n·d with |n| ≤ E²;
// - 2 ω times the image's size ≤ silhouette_near. The image's size in units of a half axis is at most
//   E / size · H / low · (1 + R / low): with A = a·v / a·a and l = h H, A_i/h_i − A_j/h_j is
//   (a·e / a·a − A_j/h_j · (h_j − h_i)) / h_i;
// - t = V / (n·d) = 1 / (Σ w_k / h_k) is at most h / (1 − 2 ω (h / h_lowest − 1)), and Embree's is off by
//   8 u E (R (R + 2 E) / V + |d| (R + 2 E) / (n·d)) of itself: both together come to less than what is left up to the
//   rays' end. The sum of `by_depth` allows a quarter and a third of that;
// - an origin is away from the plane by off_plane.
struct Least {
    Float clear, steep;
};
HWY_INLINE Least least_volume(const BlockView& view, const Seen& seen) {
    const Float one = hn::Set(d, 1.0f), edge_reach = hn::Mul(seen.edge, seen.distance);
    const Float rounding =
        hn::Mul(seen.edge, hn::MulAdd(hn::Set(d, 18.0f), seen.distance, hn::Mul(hn::Set(d, 4.0f), seen.edge)));
    const Float highest = hn::Mul(seen.high, hn::Set(d, 1.0f / view.nearest)), per_low = hn::Div(one, seen.low);
    const Float image = hn::Mul(hn::Mul(seen.edge, hn::Set(d, view.farthest / view.size)),
                                hn::Mul(per_low, hn::MulAdd(seen.distance, per_low, one)));
    const Float omega = hn::Mul(hn::Mul(rounding, hn::Set(d, u * view.reach)), highest);
    const Float by_image =
        hn::Mul(omega, hn::Max(hn::Set(d, 4.0f), hn::Mul(image, hn::Set(d, 2.0f / silhouette_near))));
    const Float before_end = hn::Min(hn::Set(d, 0.25f), hn::Sub(hn::Set(d, view.end), highest));
    const Float slope = hn::Sub(hn::Mul(seen.high, per_low), one);
    const Float depth = hn::Mul(edge_reach, hn::MulAdd(highest, hn::Set(d, view.reach), reach_of(seen)));
    const Float by_depth =
        hn::Div(hn::MulAdd(omega, hn::Mul(slope, hn::Set(d, 12.0f)), hn::Mul(depth, hn::Set(d, 32 * u))), before_end);
    const Vector size = magnitudes(seen.normal);
    const Float by_plane = hn::Mul(hn::Set(d, view.off_plane), hn::Add(hn::Add(size.x, size.y), size.z));
    const Float clear = hn::Max(hn::Max(by_image, by_depth), by_plane);
    return {clear, hn::Max(clear, hn::Mul(hn::Mul(omega, image), hn::Set(d, 2.0f / silhouette_close)))};
}

ClusterSides sides(const BlockView& view, const TriangleCluster& cluster, std::int32_t* states) {
    ClusterSides found;
    const Vector half = set(view.half), light = set(view.light), axis_a = set(view.axis_a), axis_b = set(view.axis_b);
    for (std::size_t first = 0; first < cluster.count; first += hn::Lanes(d)) {
        const Seen seen = look_at(view, cluster, first);
        // V is off by less than 16 u E R (R + 2 E), n·d by 16 u E (R + 2 E) |d|.
        const Float wrong = hn::Mul(hn::Set(d, 16 * u), hn::Mul(seen.edge, reach_of(seen)));
        const Float spread = dot(magnitudes(seen.normal), half);
        const Float volume = dot(seen.normal, seen.v[0]), along = dot(seen.normal, light);
        const Float off_plane = hn::Sub(hn::Abs(volume), hn::MulAdd(wrong, seen.distance, spread));
        const Float width = hn::Add(hn::Abs(dot(seen.normal, axis_a)), hn::Abs(dot(seen.normal, axis_b)));
        const Float steep = hn::Sub(hn::Abs(along), hn::Add(hn::MulAdd(wrong, hn::Set(d, view.reach), spread), width));
        const Mask by_place = hn::Gt(off_plane, hn::Zero(d)), by_way = hn::Gt(steep, hn::Zero(d));
        const Mask in_front = hn::Gt(volume, hn::Zero(d)), forward = hn::Gt(along, hn::Zero(d));
        // Rays that move away from the plane that they start off.
        const Mask apart = hn::And(hn::And(by_way, hn::Xor(in_front, forward)),
                                   hn::Gt(off_plane, hn::Mul(wrong, hn::Set(d, view.reach))));
        const Mask between = hn::And(hn::Gt(seen.low, hn::Set(d, 0x1p-11f * view.nearest)),
                                     hn::Lt(seen.high, hn::Set(d, (view.end - 0x1p-10f) * view.nearest)));
        const Least least = least_volume(view, seen);
        const Mask clear = hn::And(between, hn::Gt(off_plane, least.clear));
        const auto put = [&](std::uint16_t& bits, Mask mask)
                             HWY_ATTR { bits = static_cast<std::uint16_t>(bits | bits_of(mask) << first); };
        const Mask known = hn::Or(by_way, by_place),
                   along_normal = hn::Or(hn::And(by_way, forward), hn::AndNot(by_way, in_front));
        put(found.positive, hn::And(known, along_normal));
        put(found.negative, hn::AndNot(along_normal, known));
        put(found.clear, clear);
        put(found.steep, hn::And(clear, hn::Gt(off_plane, least.steep)));
        put(found.absent, apart);
        if (!states) continue;
        const hn::RebindToSigned<Tag> whole;
        const auto one = hn::Set(whole, 1),
                   side = hn::IfThenElse(hn::RebindMask(whole, along_normal), one, hn::Neg(one));
        hn::StoreU(hn::IfThenElseZero(hn::RebindMask(whole, hn::AndNot(apart, clear)), side), whole, states + first);
    }
    return found;
}

const SilhouetteKernels* silhouette_table() {
    static constexpr SilhouetteKernels functions{sides};
    return &functions;
}

} // namespace gnomon::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gnomon {
namespace {

constexpr double u = 0x1p-24;

double largest_coordinate(const Bounds& box) {
    const vec3 size = glm::max(glm::abs(box.minimum), glm::abs(box.maximum));
    return static_cast<double>(largest_component(size));
}

// Which triangles of a cluster are what for the whole block.
struct BlockSides {
    std::uint16_t positive = 0, negative = 0, absent = 0; // the rest has to be asked
    std::uint16_t flat = 0;
    bool held = false;
    std::uint32_t first = 0; // number of the first that has to be asked

    unsigned asked(std::uint32_t count) const {
        return ((1u << count) - 1u) & ~static_cast<unsigned>(positive | negative | absent);
    }
};

BlockSides block_sides(const BlockView& view, const TriangleCluster& cluster) {
    const ClusterSides sides = silhouette_kernels().sides(view, cluster, nullptr);
    const unsigned present = (1u << cluster.count) - 1u, absent = sides.absent;
    const unsigned certain = static_cast<unsigned>(sides.clear) & ~absent;
    const auto bits = [](unsigned value) { return static_cast<std::uint16_t>(value); };
    BlockSides found;
    found.positive = bits(certain & sides.positive), found.negative = bits(certain & sides.negative);
    found.absent = bits(absent), found.flat = bits(present & ~(sides.steep | absent));
    found.held = true;
    return found;
}

Bounds box_of(const TriangleCluster& cluster) {
    Bounds box;
    for (std::uint32_t i = 0; i < cluster.count; ++i)
        for (const auto& corner : cluster.corner) box.extend({corner[0][i], corner[1][i], corner[2][i]});
    return box;
}

std::int32_t number_of(const Outline& outline, const BlockSides& sides, std::uint32_t count, std::uint32_t place) {
    const std::int32_t constant = outline.first_constant();
    if (sides.positive >> place & 1u) return constant;
    if (sides.negative >> place & 1u) return constant + 1;
    if (sides.absent >> place & 1u) return constant + 2;
    const unsigned before = sides.asked(count) & ((1u << place) - 1u);
    return static_cast<std::int32_t>(sides.first) + __builtin_popcount(before);
}

// Whether triangles that show different sides for the whole block may meet in a cluster or at its rim.
bool is_mixed(const TriangleClusters& all, std::uint32_t index, const std::vector<BlockSides>& sides) {
    const ClusterNeighbours& neighbours = all.neighbours[index];
    if (neighbours.count > ClusterNeighbours::most) return true;
    unsigned positive = sides[index].positive, negative = sides[index].negative;
    for (std::uint32_t i = 0; i < neighbours.count; ++i)
        positive |= sides[neighbours.beside[i]].positive, negative |= sides[neighbours.beside[i]].negative;
    return positive != 0 && negative != 0;
}

// The edges of a cluster's triangles beside which states may differ. Those that two triangles share are added once: by
// the one whose state has to be asked, or by the one that comes first. A neighbour that the shaft does not hold, and
// one that no ray meets, is not where rays are, and neither is the shared edge.
void add_edges(const TriangleClusters& all, std::uint32_t index, const std::vector<BlockSides>& sides,
               Outline& outline) {
    const TriangleCluster& cluster = all.clusters[index];
    const ClusterNeighbours& neighbours = all.neighbours[index];
    const BlockSides& own = sides[index];
    const unsigned present = ((1u << cluster.count) - 1u) & ~static_cast<unsigned>(own.absent);
    const unsigned asked = own.asked(cluster.count);
    unsigned left = is_mixed(all, index, sides) ? present : present & (asked | neighbours.open);
    for (; left; left &= left - 1) {
        const auto i = static_cast<std::uint32_t>(__builtin_ctz(left));
        const std::int32_t here = number_of(outline, own, cluster.count, i);
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t neighbour = neighbours.over[k][i];
            std::int32_t there = outline.first_constant() + 2;
            if (neighbour != no_neighbour) {
                const auto other = static_cast<std::uint32_t>(neighbour / cluster_size);
                const auto place = static_cast<std::uint32_t>(neighbour % cluster_size);
                const BlockSides& theirs = sides[other];
                if (!theirs.held || (theirs.absent >> place & 1u)) continue;
                const bool we_ask = asked >> i & 1u, they_ask = theirs.asked(cluster_size) >> place & 1u;
                if (they_ask && !we_ask) continue;
                there = number_of(outline, theirs, all.clusters[other].count, place);
                if (we_ask == they_ask && (here == there || index * cluster_size + i > neighbour)) continue;
            }
            const std::size_t end = (k + 1) % 3;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                outline.from[axis].push_back(cluster.corner[k][axis][i]);
                outline.to[axis].push_back(cluster.corner[end][axis][i]);
            }
            outline.along.push_back(here), outline.against.push_back(there);
        }
    }
}

} // namespace

void add_triangles(const TriangleCluster& from, unsigned wanted, std::vector<TriangleCluster>& to) {
    for (; wanted; wanted &= wanted - 1) {
        const auto i = static_cast<std::size_t>(__builtin_ctz(wanted));
        if (to.empty() || to.back().count == cluster_size) {
            to.emplace_back();
            // Unused places repeat the first.
            for (int k = 0; k < 3; ++k)
                for (int axis = 0; axis < 3; ++axis)
                    std::fill_n(to.back().corner[k][axis], cluster_size, from.corner[k][axis][i]);
            to.back().triangle.fill(from.triangle[i]);
        }
        TriangleCluster& cluster = to.back();
        for (int k = 0; k < 3; ++k)
            for (int axis = 0; axis < 3; ++axis) cluster.corner[k][axis][cluster.count] = from.corner[k][axis][i];
        cluster.triangle[cluster.count++] = from.triangle[i];
    }
}

HWY_EXPORT(silhouette_table);

const SilhouetteKernels& silhouette_kernels() {
    static const SilhouetteKernels* const chosen = HWY_DYNAMIC_DISPATCH(silhouette_table)();
    return *chosen;
}

BlockView block_view(const Light& light, const Bounds& origins, float rounding) {
    BlockView view;
    if (light.type == LightType::Sphere || light.type == LightType::Mesh) return view;
    constexpr auto growth = static_cast<double>(light_growth);
    const LightFrame frame = light_frame(light, origins.center());
    const dvec3 center(origins.center()), a = growth * frame.a, b = growth * frame.b;
    dvec3 half = dvec3(origins.maximum) - center;
    half = glm::max(half, center - dvec3(origins.minimum)) * (1 + 4 * u);
    dvec3 up = glm::cross(a, b);
    if (!(glm::length(up) > 0.0)) return view;
    up = glm::normalize(up);
    const dvec3 way = frame.center - center;
    if (glm::dot(up, way) < 0.0) up = -up;
    const double height = glm::dot(up, way), spread = glm::dot(glm::abs(up), half);
    const double magnitude = std::max(largest_coordinate(origins), largest_coordinate(light_bounds(light)) * growth);
    const double most_rounding =
        std::max(static_cast<double>(rounding), magnitude * static_cast<double>(relative_step));
    view.center = vec3(center), view.half = vec3(half * (1 + 4 * u));
    view.light = vec3(way), view.up = vec3(up);
    view.axis_a = vec3(a), view.axis_b = vec3(b);
    view.nearest = static_cast<float>((height - spread) * (1 - 8 * u));
    view.farthest = static_cast<float>((height + spread) * (1 + 8 * u));
    view.reach = static_cast<float>((farthest_point(way, a, b) + glm::length(half + frame.rounding)) * (1 + 8 * u));
    view.size = static_cast<float>(std::min(glm::length(a), glm::length(b)) * (1 - 8 * u));
    view.end = static_cast<float>(1.0 - 4 * most_rounding / (height - spread));
    view.off_plane = static_cast<float>(32 * most_rounding);
    view.usable = height > 2 * spread && view.nearest > 0x1p-8f * view.reach && view.end > 0.5f;
    return view;
}

bool too_many_unknown(const BlockView& view, const TriangleClusters& all, std::span<const std::uint32_t> nearby,
                      std::size_t most) {
    constexpr std::size_t every = 16;
    std::size_t unknown = 0;
    for (std::size_t i = every / 2; i < nearby.size(); i += every) {
        const TriangleCluster& cluster = all.clusters[nearby[i]];
        unknown += static_cast<std::size_t>(__builtin_popcount(block_sides(view, cluster).asked(cluster.count)));
    }
    return every * unknown > 2 * most;
}

std::optional<Outline> find_outline(const BlockView& view, const TriangleClusters& all,
                                    std::span<const std::uint32_t> nearby, std::size_t most) {
    if (too_many_unknown(view, all, nearby, most)) return std::nullopt;
    Outline outline;
    std::vector<BlockSides> sides(all.clusters.size());
    std::uint32_t count = 0;
    for (const std::uint32_t index : nearby) {
        const TriangleCluster& cluster = all.clusters[index];
        sides[index] = block_sides(view, cluster);
        sides[index].first = count;
        const unsigned asked = sides[index].asked(cluster.count);
        count += static_cast<std::uint32_t>(__builtin_popcount(asked));
        if (count > most) return std::nullopt;
        add_triangles(cluster, asked, outline.triangles);
        add_triangles(cluster, sides[index].flat, outline.flat);
    }
    for (std::uint32_t i = 0; i < outline.flat.size(); ++i)
        outline.flat_boxes.add(i, grown_box(box_of(outline.flat[i])));
    outline.flat_boxes.pad();
    for (const std::uint32_t index : nearby) add_edges(all, index, sides, outline);
    outline.edges = outline.along.size();
    const std::size_t padded = (outline.edges + 15) / 16 * 16;
    for (int i = 0; i < 3; ++i) outline.from[i].resize(padded), outline.to[i].resize(padded);
    outline.along.resize(padded, outline.first_constant()), outline.against.resize(padded, outline.first_constant());
    return outline;
}

} // namespace gnomon
#endif
