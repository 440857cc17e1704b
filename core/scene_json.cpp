// The project's own scene documents; docs/scenes.md describes every key. Anything that is not described there is an
// error.

#include <array>
#include <filesystem>
#include <map>

#include <nlohmann/json.hpp>

#include "core/atomic_file.h"
#include "core/json_reader.h"
#include "core/primitives.h"
#include "core/scene_json.h"
#include "core/scene_load.h"

namespace gnomon {
namespace {

constexpr double far_away = 1e9; // metres
constexpr double smallest = 1e-6;

const JsonReader::Keys transform_keys = {"translate", "rotate", "scale", "matrix"};

dvec3 position(const JsonReader& value) { return value.vector3(-far_away, far_away); }

vec3 color(const JsonReader& value, double largest) {
    return value.value().is_array() ? vec3(value.vector3(0, largest)) : vec3(value.real(0, largest));
}

dmat4 read_rotation(const JsonReader& rotate) {
    if (!rotate.value().is_object()) {
        const dvec3 degrees = rotate.vector3(-1e4, 1e4);
        return rotation(degrees.z, {0, 0, 1}) * rotation(degrees.y, {0, 1, 0}) * rotation(degrees.x, {1, 0, 0});
    }
    rotate.only({"axis", "angle"});
    const dvec3 axis = rotate.at("axis").vector3(-far_away, far_away);
    if (glm::length(axis) < smallest) rotate.at("axis").fail("must not be zero");
    return rotation(rotate.at("angle").number(-1e4, 1e4), glm::normalize(axis));
}

// translate · rotate · scale, or the matrix as it is.
dmat4 read_transform(const JsonReader& object) {
    if (object.has("matrix")) {
        for (const char* key : {"translate", "rotate", "scale"})
            if (object.has(key)) object.at(key).fail("cannot stand beside 'matrix'; leave one of them out");
        const JsonReader values = object.at("matrix");
        if (values.size() != 16) values.fail("must be an array of 16 numbers, column by column");
        dmat4 matrix(1.0);
        for (size_t i = 0; i < 16; ++i)
            matrix[static_cast<int>(i / 4)][static_cast<int>(i % 4)] = values[i].number(-far_away, far_away);
        if (matrix[0][3] != 0 || matrix[1][3] != 0 || matrix[2][3] != 0 || matrix[3][3] != 1)
            values.fail("must be affine: the last row must be 0, 0, 0, 1");
        return matrix;
    }
    dmat4 transform(1.0);
    if (object.has("translate")) transform = translation(position(object.at("translate")));
    if (object.has("rotate")) transform = transform * read_rotation(object.at("rotate"));
    if (object.has("scale")) {
        const JsonReader scale = object.at("scale");
        const dvec3 factors = scale.value().is_array() ? scale.vector3(-1e6, 1e6) : dvec3(scale.number(-1e6, 1e6));
        if (factors.x == 0 || factors.y == 0 || factors.z == 0) scale.fail("must not be zero");
        transform = transform * scaling(factors);
    }
    return transform;
}

float length(const JsonReader& object, const char* key, float otherwise) {
    return object.has(key) ? object.at(key).real(smallest, far_away) : otherwise;
}

int faces(const JsonReader& object, const char* key, int minimum, int otherwise) {
    return object.has(key) ? object.at(key).integer(minimum, 4096) : otherwise;
}

vec2 plane_size(const JsonReader& object) {
    if (!object.has("size")) return vec2(1.0f);
    const JsonReader size = object.at("size");
    if (!size.value().is_array()) return vec2(size.real(smallest, far_away));
    if (size.size() != 2) size.fail("must be one number, or two: along x and z");
    return {size[0].real(smallest, far_away), size[1].real(smallest, far_away)};
}

MeshData read_box(const JsonReader& object) {
    vec3 size(1.0f);
    if (object.has("size"))
        size = object.at("size").value().is_array() ? vec3(object.at("size").vector3(smallest, far_away))
                                                    : vec3(object.at("size").real(smallest, far_away));
    return box_mesh({-0.5f * size.x, 0.0f, -0.5f * size.z}, {0.5f * size.x, size.y, 0.5f * size.z});
}

MeshData read_cylinder(const JsonReader& object) {
    if (object.has("radius") && (object.has("bottom_radius") || object.has("top_radius")))
        object.at("radius").fail("cannot stand beside 'bottom_radius' or 'top_radius'; leave one of them out");
    const float radius = length(object, "radius", 0.5f);
    const auto end = [&](const char* key) { return object.has(key) ? object.at(key).real(0, far_away) : radius; };
    const float bottom = end("bottom_radius"), top = end("top_radius");
    if (bottom == 0.0f && top == 0.0f) object.at("top_radius").fail("must not be 0 where 'bottom_radius' is");
    return cylinder_mesh(bottom, top, length(object, "height", 1.0f), faces(object, "segments", 3, 64));
}

MeshData read_torus(const JsonReader& object) {
    const float radius = length(object, "radius", 0.5f), tube = length(object, "tube_radius", 0.15f);
    if (tube >= radius)
        object.at(object.has("tube_radius") ? "tube_radius" : "radius")
            .fail("must leave a hole: the tube_radius must be below the radius");
    return torus_mesh(radius, tube, faces(object, "segments", 3, 96), faces(object, "sides", 3, 32));
}

MeshData read_tube(const JsonReader& object) {
    const JsonReader points = object.at("points");
    if (points.size() < 2) points.fail("must have at least two points");
    std::vector<vec3> line;
    for (size_t i = 0; i < points.size(); ++i) {
        line.emplace_back(position(points[i]));
        if (i > 0 && line[i] == line[i - 1]) points[i].fail("must differ from the point before it");
    }
    const std::vector<float> radii(line.size(), length(object, "radius", 0.05f));
    return tube_mesh(line, radii, faces(object, "sides", 3, 24));
}

MeshData read_grid(const JsonReader& object) {
    const float height = object.has("height") ? object.at("height").real(0, far_away) : 0.2f;
    const int seed = object.has("seed") ? object.at("seed").integer(0, 1 << 30) : 1;
    return grid_mesh(plane_size(object), faces(object, "segments", 1, 64), height, length(object, "bump_size", 0.5f),
                     static_cast<std::uint32_t>(seed));
}

struct Shape {
    const char* name;
    JsonReader::Keys keys;
    MeshData (*read)(const JsonReader& object);
};

const std::vector<Shape>& shapes() {
    static const std::vector<Shape> table = {
        {"plane",
         {"size", "segments"},
         [](const JsonReader& object) {
             const int segments = faces(object, "segments", 1, 1);
             return plane_mesh(plane_size(object), segments, segments);
         }},
        {"box", {"size"}, read_box},
        {"sphere",
         {"radius", "slices", "stacks"},
         [](const JsonReader& object) {
             return sphere_mesh(length(object, "radius", 0.5f), faces(object, "slices", 3, 64),
                                faces(object, "stacks", 2, 32));
         }},
        {"cylinder", {"radius", "bottom_radius", "top_radius", "height", "segments"}, read_cylinder},
        {"torus", {"radius", "tube_radius", "segments", "sides"}, read_torus},
        {"tube", {"points", "radius", "sides"}, read_tube},
        {"grid", {"size", "segments", "height", "bump_size", "seed"}, read_grid},
    };
    return table;
}

class DocumentLoader {
public:
    DocumentLoader(const JsonReader& document, std::filesystem::path folder)
        : document_(document), folder_(std::move(folder)) {}

    Scene load() {
        document_.only({"name", "description", "materials", "objects", "lights", "cameras"});
        if (document_.has("name")) scene_.name = document_.at("name").text();
        if (document_.has("description")) document_.at("description").text();
        read_materials();
        if (document_.has("lights"))
            for (size_t i = 0; i < document_.at("lights").size(); ++i)
                read_light(document_.at("lights")[i], folder_, scene_);
        if (document_.has("cameras"))
            for (size_t i = 0; i < document_.at("cameras").size(); ++i) read_camera(document_.at("cameras")[i], scene_);
        const JsonReader objects = document_.at("objects");
        for (size_t i = 0; i < objects.size(); ++i) read_object(objects[i], i);
        return std::move(scene_);
    }

private:
    void read_materials() {
        if (!document_.has("materials")) return;
        document_.at("materials").expect_object();
        for (const auto& item : document_.at("materials").value().items()) {
            materials_[item.key()] = add_material(document_.at("materials").at(item.key()), item.key());
            names_.push_back(item.key());
        }
    }

    std::uint32_t add_material(const JsonReader& value, const std::string& name) {
        value.only({"base_color", "emission", "roughness", "metallic"});
        Material material;
        material.name = name;
        if (value.has("base_color")) material.base_color = color(value.at("base_color"), 1);
        if (value.has("emission")) material.emission = color(value.at("emission"), 1e9);
        if (value.has("roughness")) material.roughness = value.at("roughness").real(0, 1);
        if (value.has("metallic")) material.metallic = value.at("metallic").real(0, 1);
        scene_.materials.push_back(material);
        return static_cast<std::uint32_t>(scene_.materials.size() - 1);
    }

    std::uint32_t material_of(const JsonReader& object, const std::string& name) {
        if (!object.has("material")) return add_material(JsonReader(no_keys_, object.file()), name);
        const JsonReader material = object.at("material");
        if (material.value().is_object()) return add_material(material, name);
        const auto found = materials_.find(material.text());
        if (found == materials_.end())
            material.fail("is '" + material.text() + "', which is not among the materials" +
                          did_you_mean(material.text(), names_));
        return found->second;
    }

    void read_object(const JsonReader& object, size_t index) {
        object.expect_object();
        const int kinds = object.has("shape") + object.has("gltf") + object.has("builtin");
        if (kinds != 1) object.fail("must have one of 'shape', 'gltf' and 'builtin'");
        if (object.has("shape"))
            read_shape(object, index);
        else
            read_reference(object);
    }

    void read_shape(const JsonReader& object, size_t index) {
        const std::string wanted = object.at("shape").text();
        std::vector<std::string> known;
        for (const Shape& shape : shapes()) {
            known.emplace_back(shape.name);
            if (wanted != shape.name) continue;
            JsonReader::Keys keys = {"shape", "name", "material", "light"};
            keys.insert(keys.end(), transform_keys.begin(), transform_keys.end());
            keys.insert(keys.end(), shape.keys.begin(), shape.keys.end());
            object.only(keys);
            const std::string name =
                object.has("name") ? object.at("name").text() : wanted + "-" + std::to_string(index);
            add_object(scene_, name, shape.read(object), read_transform(object), material_of(object, name));
            if (object.has("light") && object.at("light").boolean() && !add_mesh_light(scene_, scene_.objects.back()))
                object.at("light").fail("needs a material with an 'emission' above 0");
            return;
        }
        object.at("shape").fail("is '" + wanted + "', which is no shape" + did_you_mean(wanted, known));
    }

    // A glTF file or a builtin scene, with its own lights and cameras unless the document has some.
    void read_reference(const JsonReader& object) {
        const char* kind = object.has("gltf") ? "gltf" : "builtin";
        JsonReader::Keys keys = {kind, "lights", "cameras"};
        keys.insert(keys.end(), transform_keys.begin(), transform_keys.end());
        object.only(keys);
        const JsonReader reference = object.at(kind);
        const std::string specification =
            object.has("gltf") ? (folder_ / reference.text()).string() : "builtin:" + reference.text();
        if (object.has("gltf") && specification.ends_with(".json"))
            reference.fail("must be a .gltf or .glb file; scene documents do not nest");
        AppendOptions options{!document_.has("lights"), !document_.has("cameras")};
        if (object.has("lights")) options.lights = object.at("lights").boolean();
        if (object.has("cameras")) options.cameras = object.at("cameras").boolean();
        const dmat4 transform = read_transform(object);
        try {
            append_scene(scene_, load_raw_scene(specification), transform, options);
        } catch (const Error& error) {
            throw InputError(object.file() + ": " + reference.path() + ": " + error.what());
        }
    }

    const JsonReader& document_;
    std::filesystem::path folder_;
    Scene scene_;
    std::map<std::string, std::uint32_t> materials_;
    std::vector<std::string> names_;
    const nlohmann::json no_keys_ = nlohmann::json::object();
};

} // namespace

Scene load_scene_json(const std::string& path) {
    const nlohmann::json parsed = parse_json(read_file(path), path);
    const JsonReader document(parsed, path);
    return DocumentLoader(document, std::filesystem::path(path).parent_path()).load();
}

} // namespace gnomon
