#pragma once
// Primitive assembly and amplification: what turns an application's primitives into the indexed triangles that draw()
// takes. Strips, fans, quads and wide lines become triangles by fixed rules; a geometry program makes new vertices and
// triangles from each input primitive, in the order of the primitives, for any number of threads.

#include <array>
#include <cassert>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <numeric>
#include <optional>
#include <span>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "raster/draw.h"

namespace gnomon {

// Assembly keeps every triangle's winding that of its primitive, and its last vertex the primitive's provoking vertex
// under OpenGL's default (last vertex) convention. Vertices that complete no primitive are dropped, and the restart
// index ends a primitive. Triangles without area are kept: set-up culls and counts them. [OpenGL 4.6, 10.1 and
// table 13.2]
//   strip       v0 v1 v2 …     (i, i+1, i+2) for even i, (i+1, i, i+2) for odd i
//   fan         v0 v1 v2 …     (0, i+1, i+2)
//   quads       v0 v1 v2 v3    (0, 1, 3), (1, 2, 3)
//   quad strip  v0 v1 v2 v3    (2, 0, 3), (0, 1, 3): the quad 0, 1, 3, 2, likewise split so that both end in its last
inline constexpr std::uint32_t restart_index = 0xffffffffu;
std::vector<uvec3> triangles_of_strip(std::span<const std::uint32_t> indices);
std::vector<uvec3> triangles_of_fan(std::span<const std::uint32_t> indices);
std::vector<uvec3> triangles_of_quads(std::span<const std::uint32_t> indices);
std::vector<uvec3> triangles_of_quad_strip(std::span<const std::uint32_t> indices);

// The indices 0, 1, … of a draw without indices.
std::vector<std::uint32_t> sequence(std::uint32_t count);

// A line segment as the quad that covers its wide line: the segment moved by ±width/2 pixels in y where it is x-major
// (|Δx| ≥ |Δy| in pixels), in x where it is y-major, width rounded to a whole number of at least 1. In between the ends
// this covers what OpenGL's wide lines cover [OpenGL 4.6, 14.5.2]; at the ends the fill rule decides by pixel centres
// where OpenGL has the diamond-exit rule, so an end pixel may differ. Depth varies along the line only.
struct WideLine {
    std::array<vec4, 4> corners; // clip space, counter-clockwise on the screen, a quad as above
    std::array<float, 4> along;  // where each lies between a (0) and b (1), for interpolating what goes with them
};
// None where the segment lies behind the near plane; otherwise it is cut there (z ≥ −w).
std::optional<WideLine> wide_line(const vec4& a, const vec4& b, float width_pixels, glm::ivec2 viewport_size);

// What an amplification leaves: vertices and the triangles over them, in the order of the input primitives.
template <class V> class Stream {
public:
    Stream(size_t vertex_count, size_t triangle_count)
        : vertex_count_(vertex_count), triangle_count_(triangle_count),
          vertices_(std::make_unique_for_overwrite<V[]>(vertex_count)),
          triangles_(std::make_unique_for_overwrite<uvec3[]>(triangle_count)) {}

    std::span<V> vertices() { return {vertices_.get(), vertex_count_}; }
    std::span<const V> vertices() const { return {vertices_.get(), vertex_count_}; }
    std::span<uvec3> triangles() { return {triangles_.get(), triangle_count_}; }
    std::span<const uvec3> triangles() const { return {triangles_.get(), triangle_count_}; }

    // For draw(), with a vertex program that reads vertices()[i]; the stream must outlive the draw.
    Geometry geometry() const { return {static_cast<std::uint32_t>(vertex_count_), triangles()}; }

private:
    size_t vertex_count_, triangle_count_;
    std::unique_ptr<V[]> vertices_;
    std::unique_ptr<uvec3[]> triangles_;
};

// Takes what a geometry program emits for one primitive.
template <class V> class Emitter {
public:
    // Its number within this primitive, for triangle().
    std::uint32_t vertex(const V& v) {
        if (vertices_.size() - first_ >= max_vertices_)
            throw UsageError("a geometry program emits more vertices for a primitive than it declares");
        vertices_.push_back(v);
        return static_cast<std::uint32_t>(vertices_.size() - 1 - first_);
    }
    void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        assert(std::max({a, b, c}) < vertices_.size() - first_);
        const auto base = static_cast<std::uint32_t>(first_);
        triangles_.push_back({base + a, base + b, base + c});
    }
    // A triangle strip of new vertices, as a geometry shader's EmitVertex and EndPrimitive make one.
    void strip(std::span<const V> vertices) {
        for (std::uint32_t i = 0; i < vertices.size(); ++i) {
            const std::uint32_t last = vertex(vertices[i]);
            if (i >= 2) triangle(i % 2 ? last - 1 : last - 2, i % 2 ? last - 2 : last - 1, last);
        }
    }
    void strip(std::initializer_list<V> vertices) { strip(std::span<const V>(vertices.begin(), vertices.size())); }

    PassCounters counters; // samplers count their texels here

    void begin_primitive() { first_ = vertices_.size(); }
    void limit(size_t max_vertices) { max_vertices_ = max_vertices; }
    std::span<const V> vertices() const { return vertices_; }
    std::span<const uvec3> triangles() const { return triangles_; }

private:
    std::vector<V> vertices_; // of all primitives so far
    std::vector<uvec3> triangles_;
    size_t first_ = 0, max_vertices_ = 0;
};

namespace detail {

inline constexpr size_t amplify_grain = 256; // primitives of one task

// Throws UsageError where 32-bit indices cannot name so many vertices.
void check_stream_size(size_t vertices);

// program(begin, end, emitter) for chunks of primitives; it calls begin_primitive() before each. Each chunk emits into
// memory of its own; the counts then say where in the stream it goes.
template <class V, class Program>
Stream<V> amplify_chunks(Pass& pass, std::uint32_t primitives, size_t max_vertices, const Program& program) {
    std::vector<Emitter<V>> chunks(chunk_count(primitives, amplify_grain));
    parallel_for(primitives, amplify_grain, [&](size_t begin, size_t end) {
        Emitter<V>& emitter = chunks[begin / amplify_grain];
        emitter.limit(max_vertices);
        program(static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(end), emitter);
    });
    std::vector<size_t> first_vertex(chunks.size() + 1, 0), first_triangle(chunks.size() + 1, 0);
    for (size_t i = 0; i < chunks.size(); ++i) {
        first_vertex[i + 1] = first_vertex[i] + chunks[i].vertices().size();
        first_triangle[i + 1] = first_triangle[i] + chunks[i].triangles().size();
        pass.counters().add(chunks[i].counters);
    }
    check_stream_size(first_vertex.back());
    Stream<V> stream(first_vertex.back(), first_triangle.back());
    parallel_for(chunks.size(), 1, [&](size_t i, size_t) {
        std::copy(chunks[i].vertices().begin(), chunks[i].vertices().end(),
                  stream.vertices().begin() + static_cast<std::ptrdiff_t>(first_vertex[i]));
        const auto base = static_cast<std::uint32_t>(first_vertex[i]);
        uvec3* out = stream.triangles().data() + first_triangle[i];
        for (const uvec3& t : chunks[i].triangles()) *out++ = t + uvec3(base);
        chunks[i] = {};
    });
    PassCounters& counters = pass.counters();
    ++counters.draws;
    counters.vertices += primitives;
    counters.bytes_written += static_cast<std::int64_t>(first_vertex.back() * sizeof(V)) +
                              static_cast<std::int64_t>(first_triangle.back() * sizeof(uvec3));
    return stream;
}

} // namespace detail

// The geometry stage: program(primitive, Emitter<V>&) for each of the primitives, at most `max_vertices` vertices each
// (more is a UsageError). Counts one draw, one vertex program invocation a primitive, and the stream as bytes written,
// as transform feedback would; drawing the stream counts again what drawing costs.
template <class V, class Program>
Stream<V> amplify(Pass& pass, std::uint32_t primitives, int max_vertices, const Program& program) {
    return detail::amplify_chunks<V>(pass, primitives, static_cast<size_t>(max_vertices),
                                     [&](std::uint32_t begin, std::uint32_t end, Emitter<V>& emitter) {
                                         for (std::uint32_t i = begin; i < end; ++i) {
                                             emitter.begin_primitive();
                                             program(i, emitter);
                                         }
                                     });
}

} // namespace gnomon
