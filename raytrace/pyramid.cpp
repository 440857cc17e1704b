#include "raytrace/pyramid.h"

#include <algorithm>
#include <cmath>

namespace gnomon {
namespace {

constexpr double u = 0x1p-24;

double largest(dvec3 v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }
double sum_of_magnitudes(dvec3 v) { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); }

LightFrame flat_frame(const Light& light) {
    const dvec2 half = 0.5 * dvec2(light.size);
    LightFrame frame{dvec3(light.position), half.x * dvec3(light.tangent), half.y * dvec3(bitangent(light)), {}};
    // A point is centre + tangent·(s·width) + bitangent·(t·height): three rounded products and two rounded sums.
    // Coordinates in which both axes are zero come out exactly.
    for (int i = 0; i < 3; ++i)
        if (frame.a[i] != 0.0 || frame.b[i] != 0.0)
            frame.rounding[i] = 6 * u * (std::abs(frame.center[i]) + std::abs(frame.a[i]) + std::abs(frame.b[i]));
    return frame;
}

// A square around the limb disk that light_points() makes for this receiver.
LightFrame sphere_frame(const Light& light, vec3 receiver) {
    const dvec3 center(light.position), to_receiver = dvec3(receiver) - center;
    const double distance = glm::length(to_receiver), radius = 0.5 * static_cast<double>(light.size.x);
    // From within, light_points() gives the centre alone: a disk too small to matter.
    const dvec3 axis = distance > 0.0 ? to_receiver / distance : dvec3(0, 1, 0);
    const dvec3 a = glm::normalize(glm::cross(axis, std::abs(axis.x) < 0.9 ? dvec3(1, 0, 0) : dvec3(0, 0, 1)));
    const double limb =
        distance > radius ? radius * std::sqrt(1.0 - radius * radius / (distance * distance)) : 1e-6 * radius;
    const dvec3 limb_center = distance > radius ? center + axis * (radius * radius / distance) : center;
    LightFrame frame{limb_center, limb * a, limb * glm::cross(axis, a), {}};
    // The axis is wrong by the rounding of the distance, some 4 u of the coordinates, and 1 − (r/d)² by 4 u, which
    // its root multiplies by at most 1/√(1 − 1/1.01²) ≈ 7 halves.
    frame.rounding = dvec3(32 * u * (largest(center) + largest(dvec3(receiver)) + radius));
    frame.usable = distance > 1.01 * radius;
    return frame;
}

// Where rays end: EmbreeScene stops them short of the target by the rounding of its coordinates.
void set_ends(Pyramid& pyramid, const LightFrame& frame, const ShadowOrigin& origin, double height_of_apex) {
    const dvec3 spread = glm::abs(frame.a) + glm::abs(frame.b) + frame.rounding;
    const double step = static_cast<double>(relative_step), apex_rounding = static_cast<double>(origin.rounding);
    double nearest_target = 0.0, shortest = height_of_apex;
    for (int i = 0; i < 3; ++i) {
        nearest_target = std::max(nearest_target, std::abs(frame.center[i]) - spread[i]);
        shortest = std::max(shortest, std::abs(frame.center[i] - static_cast<double>(origin.position[i])) - spread[i]);
    }
    const double least = std::max(apex_rounding, nearest_target * step),
                 most = std::max(apex_rounding, largest(glm::abs(frame.center) + spread) * step);
    pyramid.end_maximum = static_cast<float>(1.0 - least / largest(dvec3(pyramid.reach)) + 4 * u);
    pyramid.end_minimum = static_cast<float>(std::max(0.0, 1.0 - most / shortest - 4 * u));
}

// From the origin to the point of its foot on a triangle, moved inside where it is outside.
double distance_to(const std::array<vec3, 3>& corners, dvec3 origin) {
    const dvec3 a(corners[0]), ab = dvec3(corners[1]) - a, ac = dvec3(corners[2]) - a, way = origin - a;
    const dvec3 normal = glm::cross(ab, ac);
    const double area = glm::dot(normal, normal);
    double s = area > 0.0 ? glm::dot(glm::cross(way, ac), normal) / area : 0.0;
    double t = area > 0.0 ? glm::dot(glm::cross(ab, way), normal) / area : 0.0;
    s = std::clamp(s, 0.0, 1.0), t = std::clamp(t, 0.0, 1.0 - s);
    return largest(a + s * ab + t * ac - origin);
}

void set_planes(Pyramid& pyramid, dvec3 center, dvec3 a, dvec3 b, dvec3 up, dvec3 horizon) {
    int count = 0;
    const auto add = [&](dvec3 normal, double offset) {
        const double scale = 1.0 / sum_of_magnitudes(normal);
        pyramid.normal[count] = vec3(normal * scale);
        pyramid.offset[count++] = static_cast<float>(offset * scale);
    };
    const auto side = [&](dvec3 out, dvec3 along) {
        const dvec3 normal = glm::cross(center + out, along);
        add(glm::dot(normal, out) > 0.0 ? normal : -normal, 0.0);
    };
    side(a, b), side(-a, b), side(b, a), side(-b, a);
    add(up, glm::dot(up, center));
    add(-up, 0.0);
    add(-horizon, 0.0);
}

// Whether all points of the light are above the receiver's horizon, or none is, as faces() computes it in float:
// within 4 u of the terms' magnitudes.
void set_facing(Pyramid& pyramid, const LightFrame& frame, const Receiver& receiver) {
    const dvec3 n(receiver.geometric_normal), way = frame.center - dvec3(receiver.position);
    const dvec3 spread = glm::abs(frame.a) + glm::abs(frame.b) + frame.rounding;
    const double middle = glm::dot(n, way), width = std::abs(glm::dot(n, frame.a)) + std::abs(glm::dot(n, frame.b));
    const double margin = glm::dot(glm::abs(n), frame.rounding + 8 * u * (glm::abs(way) + spread));
    pyramid.all_face = middle - width > margin;
    pyramid.none_faces = middle + width < -margin;
}

} // namespace

double farthest_point(dvec3 center, dvec3 a, dvec3 b) {
    return std::max({glm::length(center + a + b), glm::length(center + a - b), glm::length(center - a + b),
                     glm::length(center - a - b)});
}

LightFrame light_frame(const Light& light, vec3 receiver) {
    if (light.type == LightType::Sphere) return sphere_frame(light, receiver);
    LightFrame frame = flat_frame(light);
    frame.usable = light.type != LightType::Mesh;
    return frame;
}

Pyramid pyramid_of(const Light& light, const Receiver& receiver, const ShadowOrigin& origin,
                   const std::array<vec3, 3>& own_corners) {
    Pyramid pyramid;
    LightFrame frame = light_frame(light, receiver.position);
    if (!frame.usable) return pyramid;
    set_facing(pyramid, frame, receiver);
    frame.a *= light_growth, frame.b *= light_growth;
    const dvec3 apex(origin.position), center = frame.center - apex, a = frame.a, b = frame.b;
    dvec3 up = glm::cross(a, b);
    const double area = glm::length(up);
    if (!(area > 0.0)) return pyramid;
    up /= area;
    double height = glm::dot(up, center);
    if (height < 0.0) up = -up, height = -height;
    // Seen nearly edge-on, or so far away that the axes drown in rounding: no proofs.
    const double magnitude = std::max(largest(apex), largest(glm::abs(frame.center) + glm::abs(a) + glm::abs(b)));
    const double growth = static_cast<double>(proof_growth) * magnitude;
    if (height < 0x1p-10 * largest(center) || height < 16 * growth || std::min(largest(a), largest(b)) < 16 * growth)
        return pyramid;

    const dvec3 reach = glm::abs(center) + glm::abs(a) + glm::abs(b) + frame.rounding;
    pyramid.origin = origin.position;
    for (size_t k = 0; k < 3; ++k) pyramid.own[k] = own_corners[k] - origin.position;
    pyramid.own_distance = static_cast<float>(distance_to(own_corners, apex) * (1.0 + 0x1p-10));
    pyramid.center = vec3(center), pyramid.axis_a = vec3(a), pyramid.axis_b = vec3(b);
    pyramid.reach = vec3(reach * (1 + 4 * u));
    pyramid.longest = static_cast<float>((farthest_point(center, a, b) + glm::length(frame.rounding)) * (1 + 8 * u));
    // The light's points are off by their rounding, and their difference to the origin is rounded; so are ours.
    const dvec3 slack = (frame.rounding + 4 * u * reach) * (1 + 4 * u);
    pyramid.slack = vec3(slack);
    set_ends(pyramid, frame, origin, height / sum_of_magnitudes(up));
    set_planes(pyramid, center, a, b, up, dvec3(receiver.geometric_normal));
    pyramid.growth = static_cast<float>(growth * (1 + 4 * u));

    const dvec3 to_height = up / height, to_a = a / glm::dot(a, a), to_b = b / glm::dot(b, b);
    pyramid.height = vec3(to_height), pyramid.to_a = vec3(to_a), pyramid.to_b = vec3(to_b);
    pyramid.center_a = static_cast<float>(glm::dot(to_a, center));
    pyramid.center_b = static_cast<float>(glm::dot(to_b, center));
    const double off_plane = glm::dot(glm::abs(to_height), slack);
    pyramid.wrong_height = static_cast<float>(off_plane + 8 * u * glm::dot(glm::abs(to_height), reach));
    const auto wrong = [&](dvec3 to) {
        return static_cast<float>(
            2.0 * (glm::dot(glm::abs(to), slack) + glm::dot(glm::abs(to), reach) * (off_plane + 16 * u)));
    };
    pyramid.wrong_a = wrong(to_a), pyramid.wrong_b = wrong(to_b);
    pyramid.usable = off_plane < 0x1p-4;
    return pyramid;
}

Bounds light_bounds(const Light& light) {
    Bounds bounds;
    if (light.type == LightType::Sphere) {
        bounds.extend(light.position - vec3(0.5f * light.size.x));
        bounds.extend(light.position + vec3(0.5f * light.size.x));
        return bounds;
    }
    const LightFrame frame = flat_frame(light);
    const dvec3 spread = glm::abs(frame.a) + glm::abs(frame.b);
    bounds.extend(vec3(frame.center - spread));
    bounds.extend(vec3(frame.center + spread));
    return bounds;
}

} // namespace gnomon
