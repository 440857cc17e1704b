// Scenes as binary glTF 2.0, written so that load_scene reads back the same bits: triangles are grouped by object,
// every object is a node without a transform, numbers in JSON are printed so that they parse to the same value.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>

#include <nlohmann/json.hpp>
#include <tiny_gltf.h>

#include "core/atomic_file.h"
#include "core/scene.h"

namespace gnomon {
namespace {

using nlohmann::json;

constexpr int float_type = 5126, uint_type = 5125;

// Adding zero makes −0 a 0, which it is again after loading: one scene, one file. JSON has no infinities; callers leave
// them out.
double exact(float value) { return static_cast<double>(value) + 0.0; }
json exact(vec3 v) { return json::array({exact(v.x), exact(v.y), exact(v.z)}); }

// A colour in [0, 1] and a power of two whose product is `value` exactly: glTF splits every brightness so.
struct Split {
    vec3 color;
    float strength;
};
Split split(vec3 value) {
    const float largest = std::max({value.x, value.y, value.z});
    int exponent = 0;
    if (largest > 1.0f) std::frexp(largest, &exponent);
    const float strength = std::ldexp(1.0f, exponent);
    return {value / strength, strength};
}

// The image as a PNG in a data URI.
std::string png_uri(const Image<glm::u8vec4>& image) {
    tinygltf::Image source;
    source.width = image.width(), source.height = image.height();
    source.component = 4, source.bits = 8, source.pixel_type = TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE;
    source.image.resize(image.size() * 4);
    std::memcpy(source.image.data(), image.data(), source.image.size());
    const std::string folder, name = "texture.png";
    std::string uri;
    if (!tinygltf::WriteImageData(&folder, &name, &source, true, &uri, nullptr))
        throw Error(ExitCode::Internal, "a texture could not be encoded as PNG");
    return uri;
}

class Writer {
public:
    explicit Writer(const Scene& scene) : scene_(scene) {
        document_["asset"] = {{"version", "2.0"}, {"generator", "gnomon"}};
        document_["scene"] = 0;
        document_["scenes"] = json::array({{{"nodes", json::array()}}});
        for (const char* key : {"nodes", "meshes", "accessors", "bufferViews", "materials", "extensionsUsed"})
            document_[key] = json::array();
    }

    void write(const std::string& path) {
        add_textures();
        add_materials();
        for (size_t i = 0; i < scene_.objects.size(); ++i) add_object_node(scene_.objects[i]);
        add_lights();
        for (const Camera& camera : scene_.cameras) add_camera(camera);
        for (const char* key : {"extensionsUsed", "nodes", "meshes", "accessors", "bufferViews", "materials"})
            if (document_[key].empty()) document_.erase(key);
        if (!binary_.empty()) document_["buffers"] = json::array({{{"byteLength", binary_.size()}}});
        write_chunks(path);
    }

private:
    // In file order, straight from where they are: the binary chunk of a big scene is not copied once more.
    void write_chunks(const std::string& path) {
        std::string text = document_.dump();
        text.resize((text.size() + 3) / 4 * 4, ' ');
        const size_t total = 12 + 8 + text.size() + (binary_.empty() ? 0 : 8 + binary_.size());
        if (total > 0xffffffffu)
            throw InputError(path + ": the scene needs more than the 4 GiB that a .glb file can have; split it");
        const auto u32 = [](size_t value) { return static_cast<std::uint32_t>(value); };
        const std::array<std::uint32_t, 5> head = {0x46546c67, 2, u32(total), u32(text.size()), 0x4e4f534a};
        const std::array<std::uint32_t, 2> body = {u32(binary_.size()), 0x004e4942};
        write_atomically(path, [&](const std::string& temporary) {
            std::ofstream file(temporary, std::ios::binary);
            const auto put = [&](const void* bytes, size_t size) {
                file.write(static_cast<const char*>(bytes), static_cast<std::streamsize>(size));
            };
            put(head.data(), sizeof head);
            put(text.data(), text.size());
            if (!binary_.empty()) {
                put(body.data(), sizeof body);
                put(binary_.data(), binary_.size());
            }
            file.flush();
            if (!file) throw InputError(path + ": cannot be written; check the space left on the disk");
        });
    }

    size_t add_view(const void* bytes, size_t size) {
        const size_t offset = binary_.size();
        binary_.resize(offset + (size + 3) / 4 * 4); // accessors are aligned to their components
        if (size > 0) std::memcpy(binary_.data() + offset, bytes, size);
        document_["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", offset}, {"byteLength", size}});
        return document_["bufferViews"].size() - 1;
    }

    size_t add_accessor(const void* bytes, size_t size, size_t count, int type, const char* shape) {
        document_["accessors"].push_back(
            {{"bufferView", add_view(bytes, size)}, {"componentType", type}, {"count", count}, {"type", shape}});
        return document_["accessors"].size() - 1;
    }

    template <class Vector> size_t add_vectors(std::span<const Vector> values) {
        return add_accessor(values.data(), values.size_bytes(), values.size(), float_type,
                            Vector::length() == 3 ? "VEC3" : "VEC2");
    }

    void use_extension(const char* name) {
        json& used = document_["extensionsUsed"];
        if (std::find(used.begin(), used.end(), name) == used.end()) used.push_back(name);
    }

    void add_node(json node) {
        document_["scenes"][0]["nodes"].push_back(document_["nodes"].size());
        document_["nodes"].push_back(std::move(node));
    }

    void add_textures() {
        for (const Texture& texture : scene_.textures) {
            const auto wrap = [](Texture::Wrap mode) {
                return mode == Texture::Wrap::Clamp ? 33071 : mode == Texture::Wrap::Mirror ? 33648 : 10497;
            };
            document_["samplers"].push_back({{"wrapS", wrap(texture.wrap_u)}, {"wrapT", wrap(texture.wrap_v)}});
            json entry = {{"sampler", document_["samplers"].size() - 1}};
            if (!texture.image.empty()) {
                document_["images"].push_back({{"name", texture.name}, {"uri", png_uri(texture.image)}});
                entry["source"] = document_["images"].size() - 1;
            }
            document_["textures"].push_back(std::move(entry));
        }
    }

    void add_materials() {
        for (const Material& material : scene_.materials) {
            const vec3 c = material.base_color;
            json surface = {{"baseColorFactor", {exact(c.x), exact(c.y), exact(c.z), 1.0}},
                            {"metallicFactor", exact(material.metallic)},
                            {"roughnessFactor", exact(material.roughness)}};
            if (material.base_color_texture >= 0)
                surface["baseColorTexture"] = {{"index", material.base_color_texture}};
            json entry = {{"name", material.name}, {"pbrMetallicRoughness", std::move(surface)}, {"doubleSided", true}};
            if (material.emission != vec3(0.0f)) {
                const Split emission = split(material.emission);
                entry["emissiveFactor"] = exact(emission.color);
                if (emission.strength != 1.0f) {
                    entry["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] =
                        exact(emission.strength);
                    use_extension("KHR_materials_emissive_strength");
                }
            }
            document_["materials"].push_back(std::move(entry));
        }
    }

    // An object's own vertices, in order of their index in the scene: shared vertices stay shared, and unused ones stay
    // behind.
    void add_object_node(const Object& object) {
        const std::span triangles = std::span(scene_.triangles).subspan(object.first_triangle, object.triangle_count);
        std::uint32_t lowest = 0xffffffffu, highest = 0;
        for (const uvec3 t : triangles) {
            lowest = std::min({lowest, t.x, t.y, t.z});
            highest = std::max({highest, t.x, t.y, t.z});
        }
        std::vector<std::uint32_t> local(triangles.empty() ? 0 : highest - lowest + 1, 0);
        for (const uvec3 t : triangles)
            for (int corner = 0; corner < 3; ++corner) local[t[corner] - lowest] = 1;
        std::vector<std::uint32_t> used;
        for (std::uint32_t i = 0; i < local.size(); ++i)
            if (local[i]) local[i] = static_cast<std::uint32_t>(used.size()), used.push_back(lowest + i);
        std::vector<uvec3> indices;
        indices.reserve(triangles.size());
        for (const uvec3 t : triangles)
            indices.emplace_back(local[t.x - lowest], local[t.y - lowest], local[t.z - lowest]);

        json attributes;
        const std::vector<vec3> positions = gather(scene_.positions, used);
        attributes["POSITION"] = add_vectors<vec3>(positions);
        json& accessor = document_["accessors"].back(); // glTF asks for the range of positions
        accessor["min"] = exact(object.bounds.minimum);
        accessor["max"] = exact(object.bounds.maximum);
        if (!scene_.normals.empty()) {
            const std::vector<vec3> normals = gather(scene_.normals, used);
            const bool any = std::any_of(normals.begin(), normals.end(), [](vec3 n) { return n != vec3(0.0f); });
            if (any) attributes["NORMAL"] = add_vectors<vec3>(normals);
        }
        if (!scene_.uvs.empty()) attributes["TEXCOORD_0"] = add_vectors<vec2>(gather(scene_.uvs, used));
        const size_t index_accessor =
            add_accessor(indices.data(), indices.size() * sizeof(uvec3), indices.size() * 3, uint_type, "SCALAR");
        json primitive = {
            {"attributes", std::move(attributes)}, {"indices", index_accessor}, {"material", object.material}};
        document_["meshes"].push_back({{"name", object.name}, {"primitives", json::array({std::move(primitive)})}});
        json node = {{"name", object.name}, {"mesh", document_["meshes"].size() - 1}};
        // Without this mark an emissive quad would become a second light on loading, or one where there was none.
        const vec3 emission = scene_.materials[object.material].emission;
        if (object.light_source || emission != vec3(0.0f)) node["extras"]["light_source"] = object.light_source;
        add_node(std::move(node));
    }

    template <class Value>
    static std::vector<Value> gather(const std::vector<Value>& values, const std::vector<std::uint32_t>& used) {
        std::vector<Value> gathered;
        gathered.reserve(used.size());
        for (const std::uint32_t i : used) gathered.push_back(values[i]);
        return gathered;
    }

    // A node at `position` whose x is `right` and whose −z is `forward`; column by column.
    static json frame(vec3 position, vec3 right, vec3 up, vec3 forward) {
        json matrix = json::array();
        for (const vec3 column : {right, up, -forward, position}) {
            for (int i = 0; i < 3; ++i) matrix.push_back(exact(column[i]));
            matrix.push_back(matrix.size() == 15 ? 1.0 : 0.0);
        }
        return matrix;
    }

    void add_lights() {
        if (scene_.lights.empty()) return;
        use_extension("KHR_lights_punctual");
        json& lights = document_["extensions"]["KHR_lights_punctual"]["lights"];
        for (const Light& light : scene_.lights) {
            const Split intensity = split(light.intensity);
            json entry = {{"name", light.name},
                          {"type", punctual_type(light.type)},
                          {"color", exact(intensity.color)},
                          {"intensity", exact(intensity.strength)}};
            if (entry["type"] == "spot")
                entry["spot"] = {{"innerConeAngle", exact(light.inner_cone)},
                                 {"outerConeAngle", exact(light.outer_cone)}};
            if (light.range < infinity && light.range > 0.0f) entry["range"] = exact(light.range);
            json node = {{"name", light.name}};
            if (light.type != LightType::Mesh) // whose triangles lie in the world
                node["matrix"] = frame(light.position, light.tangent, -bitangent(light), light.direction);
            node["extensions"]["KHR_lights_punctual"]["light"] = lights.size();
            if (is_area(light)) node["extras"]["area"] = area(light);
            lights.push_back(std::move(entry));
            add_node(std::move(node));
        }
    }

    // What a reader that knows no area lights shows instead.
    static const char* punctual_type(LightType type) {
        if (type == LightType::Directional) return "directional";
        return type == LightType::Point || type == LightType::Sphere || type == LightType::Mesh ? "point" : "spot";
    }

    json area(const Light& light) {
        json entry = {{"shape", light_type_name(light.type)}};
        if (light.type == LightType::Mesh) {
            std::vector<vec3> corners;
            for (const LightTriangle& t : light.triangles) corners.insert(corners.end(), {t.a, t.b, t.c});
            entry["triangles"] = {{"count", light.triangles.size()}, {"accessor", add_vectors<vec3>(corners)}};
            return entry;
        }
        if (light.type == LightType::Disk || light.type == LightType::Sphere)
            entry["diameter"] = exact(light.size.x);
        else
            entry["size"] = {exact(light.size.x), exact(light.size.y)};
        if (light.type == LightType::TexturedRectangle && !light.texture.empty())
            entry["texture"] = {{"width", light.texture.width()},
                                {"height", light.texture.height()},
                                {"accessor", add_vectors<vec3>(light.texture.values())}};
        return entry;
    }

    void add_camera(const Camera& camera) {
        json entry = {{"name", camera.name}, {"type", camera.orthographic ? "orthographic" : "perspective"}};
        json planes = {{"znear", exact(camera.near_plane)}, {"zfar", exact(camera.far_plane)}};
        if (camera.orthographic) {
            planes["xmag"] = planes["ymag"] = 0.5 * exact(camera.view_height);
        } else {
            planes["yfov"] = exact(camera.vertical_fov);
        }
        entry[camera.orthographic ? "orthographic" : "perspective"] = std::move(planes);
        document_["cameras"].push_back(std::move(entry));
        const vec3 right = glm::normalize(glm::cross(camera.forward, camera.up));
        add_node({{"name", camera.name},
                  {"camera", document_["cameras"].size() - 1},
                  {"matrix", frame(camera.position, right, camera.up, camera.forward)}});
    }

    const Scene& scene_;
    json document_;
    std::vector<unsigned char> binary_;
};

} // namespace

void export_glb(const Scene& scene, const std::string& path) { Writer(scene).write(path); }

} // namespace gnomon
