// glTF 2.0 through tinygltf: node hierarchy flattened, triangles, base colours, lights and cameras. What a shadow does
// not depend on (metalness, normal maps, animation) is left out; what changes shapes and is left out gets a warning.

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>

#include <fmt/format.h>
#include <glm/gtc/quaternion.hpp>
#include <nlohmann/json.hpp>
#include <tiny_gltf.h>

#include "core/atomic_file.h"
#include "core/gltf_accessor.h"
#include "core/gltf_check.h"
#include "core/gltf_lights.h"
#include "core/gltf_mesh.h"
#include "core/json_reader.h"
#include "core/scene_load.h"

namespace gnomon {
namespace {

// Images that no base colour uses are not worth decoding, and one that cannot be decoded must not cost the geometry.
struct ImageLoading {
    std::vector<bool> used;
    std::vector<std::string> warnings;
};

bool load_image(tinygltf::Image* image, int index, std::string*, std::string*, int width, int height,
                const unsigned char* bytes, int size, void* user) {
    auto& loading = *static_cast<ImageLoading*>(user);
    if (!loading.used[static_cast<size_t>(index)]) return true;
    std::string error, warning;
    if (!tinygltf::LoadImageData(image, index, &error, &warning, width, height, bytes, size, nullptr)) {
        image->image.clear();
        loading.warnings.push_back(fmt::format("images[{}] cannot be decoded and is left out", index));
    }
    return true;
}

std::vector<bool> used_images(const JsonReader& document) {
    std::vector<bool> used(document.has("images") ? document.at("images").size() : 0, false);
    if (!document.has("materials")) return used;
    for (size_t i = 0; i < document.at("materials").size(); ++i) {
        const JsonReader material = document.at("materials")[i];
        if (!material.has("pbrMetallicRoughness") || !material.at("pbrMetallicRoughness").has("baseColorTexture"))
            continue;
        const JsonReader texture =
            document.at("textures")[material.at("pbrMetallicRoughness").at("baseColorTexture").at("index").count()];
        if (texture.has("source")) used[texture.at("source").count()] = true;
    }
    return used;
}

tinygltf::Model parse_model(const std::string& bytes, bool binary, const std::string& path, ImageLoading& loading) {
    if (bytes.size() > 0xffffffffu) throw InputError(path + ": larger than 4 GiB, which glTF cannot be; split it");
    tinygltf::TinyGLTF parser;
    parser.SetImageLoader(load_image, &loading);
    tinygltf::Model model;
    std::string error, warning;
    const std::string folder = std::filesystem::path(path).parent_path().string();
    const auto length = static_cast<unsigned>(bytes.size());
    bool parsed = false;
    try {
        parsed = binary
                     ? parser.LoadBinaryFromMemory(&model, &error, &warning,
                                                   reinterpret_cast<const unsigned char*>(bytes.data()), length, folder)
                     : parser.LoadASCIIFromString(&model, &error, &warning, bytes.data(), length, folder);
    } catch (const std::exception& exception) {
        error = exception.what();
    }
    if (!parsed)
        throw InputError(path + ": not a readable glTF file: " + one_line(error.empty() ? "unknown reason" : error));
    if (!one_line(warning).empty()) loading.warnings.push_back(one_line(warning));
    return model;
}

// One loading of one file: the scene under construction and what has to be remembered on the way.
class Loader {
public:
    Loader(const tinygltf::Model& model, const JsonReader& document, const std::string& path)
        : model_(model), document_(document), path_(path), file_{model, path_} {}

    Scene load(const std::vector<std::string>& image_warnings) {
        for (const std::string& warning : image_warnings) warn(warning);
        read_textures();
        read_materials();
        traverse();
        warn_about_leftovers();
        return std::move(scene_);
    }

private:
    void warn(const std::string& what) { scene_.warnings.push_back(one_line(path_ + ": " + what)); }

    void read_textures() {
        for (const tinygltf::Texture& source : model_.textures) {
            Texture texture;
            const auto wrap = [](int mode) {
                return mode == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE     ? Texture::Wrap::Clamp
                       : mode == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? Texture::Wrap::Mirror
                                                                       : Texture::Wrap::Repeat;
            };
            if (source.sampler >= 0) {
                const tinygltf::Sampler& sampler = model_.samplers[static_cast<size_t>(source.sampler)];
                texture.wrap_u = wrap(sampler.wrapS), texture.wrap_v = wrap(sampler.wrapT);
            }
            if (source.source >= 0) read_image_of(texture, model_.images[static_cast<size_t>(source.source)]);
            scene_.textures.push_back(std::move(texture));
        }
    }

    static void read_image_of(Texture& texture, const tinygltf::Image& image) {
        texture.name = image.name.empty() ? image.uri.substr(0, 64) : image.name;
        const size_t bytes = image.bits == 16 ? 2 : 1;
        const bool usable = image.width > 0 && image.height > 0 && image.width <= max_image_side &&
                            image.height <= max_image_side && image.component == 4;
        if (!usable ||
            image.image.size() < static_cast<size_t>(image.width) * static_cast<size_t>(image.height) * 4 * bytes)
            return;
        texture.image = Image<glm::u8vec4>(image.width, image.height);
        // Of 16 bits the upper half is kept (little endian).
        for (size_t i = 0; i < texture.image.size(); ++i)
            for (int channel = 0; channel < 4; ++channel)
                texture.image.data()[i][channel] =
                    image.image[(i * 4 + static_cast<size_t>(channel)) * bytes + bytes - 1];
    }

    void read_materials() {
        for (size_t i = 0; i < model_.materials.size(); ++i) {
            const tinygltf::Material& source = model_.materials[i];
            const auto& surface = source.pbrMetallicRoughness;
            Material material;
            material.name = source.name.empty() ? fmt::format("material-{}", i) : source.name;
            if (surface.baseColorFactor.size() >= 3)
                material.base_color =
                    vec3(surface.baseColorFactor[0], surface.baseColorFactor[1], surface.baseColorFactor[2]);
            if (surface.metallicRoughnessTexture.index < 0) { // a texture would vary them; without it all is diffuse
                material.roughness = static_cast<float>(std::clamp(surface.roughnessFactor, 0.0, 1.0));
                material.metallic = static_cast<float>(std::clamp(surface.metallicFactor, 0.0, 1.0));
            }
            if (source.emissiveFactor.size() == 3)
                material.emission =
                    vec3(dvec3(source.emissiveFactor[0], source.emissiveFactor[1], source.emissiveFactor[2]) *
                         emissive_strength(i));
            const int texture = surface.baseColorTexture.index;
            if (texture >= 0 && !scene_.textures[static_cast<size_t>(texture)].image.empty()) {
                material.base_color_texture = texture;
                if (surface.baseColorTexture.texCoord != 0) ++other_texture_coordinates_;
            }
            if (source.alphaMode == "MASK" || source.alphaMode == "BLEND") ++transparent_materials_;
            if (source.emissiveTexture.index >= 0) ++emissive_textures_;
            scene_.materials.push_back(std::move(material));
        }
    }

    double emissive_strength(size_t i) const {
        const JsonReader material = document_.at("materials")[i];
        if (!material.has("extensions") || !material.at("extensions").has("KHR_materials_emissive_strength"))
            return 1.0;
        const JsonReader extension = material.at("extensions").at("KHR_materials_emissive_strength");
        return extension.has("emissiveStrength") ? extension.at("emissiveStrength").number(0, 1e30) : 1.0;
    }

    // Primitives without a material share one that is made when the first of them appears.
    std::uint32_t material_index(int index) {
        if (index >= 0) return static_cast<std::uint32_t>(index);
        if (default_material_ < 0) {
            default_material_ = static_cast<int>(scene_.materials.size());
            scene_.materials.emplace_back();
        }
        return static_cast<std::uint32_t>(default_material_);
    }

    std::vector<int> root_nodes() const {
        if (!model_.scenes.empty()) return model_.scenes[static_cast<size_t>(std::max(0, model_.defaultScene))].nodes;
        std::vector<bool> is_child(model_.nodes.size(), false);
        for (const tinygltf::Node& node : model_.nodes)
            for (const int child : node.children) is_child[static_cast<size_t>(child)] = true;
        std::vector<int> roots;
        for (size_t i = 0; i < is_child.size(); ++i)
            if (!is_child[i]) roots.push_back(static_cast<int>(i));
        return roots;
    }

    // Depth first, in the document's order; without recursion, because hierarchies can be deep.
    void traverse() {
        struct Visit {
            int node;
            dmat4 parent;
        };
        std::vector<Visit> stack;
        std::vector<bool> visited(model_.nodes.size(), false);
        const auto push = [&](const std::vector<int>& nodes, const dmat4& parent) {
            for (auto node = nodes.rbegin(); node != nodes.rend(); ++node) stack.push_back({*node, parent});
        };
        push(root_nodes(), dmat4(1.0));
        while (!stack.empty()) {
            const Visit visit = stack.back();
            stack.pop_back();
            const auto index = static_cast<size_t>(visit.node);
            if (visited[index])
                document_.at("nodes")[index].fail(
                    "is reached twice; the nodes of glTF must form a tree, export the file again");
            visited[index] = true;
            const dmat4 transform = visit.parent * local_transform(model_.nodes[index]);
            read_node(index, transform);
            push(model_.nodes[index].children, transform);
        }
    }

    static dmat4 local_transform(const tinygltf::Node& node) {
        dmat4 matrix(1.0);
        if (node.matrix.size() == 16) {
            for (int column = 0; column < 4; ++column)
                for (int row = 0; row < 4; ++row)
                    matrix[column][row] = node.matrix[static_cast<size_t>(column * 4 + row)];
            return matrix;
        }
        if (node.rotation.size() == 4) {
            const glm::dquat q(node.rotation[3], node.rotation[0], node.rotation[1], node.rotation[2]);
            matrix = glm::mat4_cast(glm::length(q) > 0 ? glm::normalize(q) : glm::dquat(1, 0, 0, 0));
        }
        if (node.scale.size() == 3)
            for (int axis = 0; axis < 3; ++axis) matrix[axis] *= node.scale[static_cast<size_t>(axis)];
        if (node.translation.size() == 3)
            matrix[3] = dvec4(node.translation[0], node.translation[1], node.translation[2], 1.0);
        return matrix;
    }

    void read_node(size_t index, const dmat4& transform) {
        const tinygltf::Node& node = model_.nodes[index];
        const JsonReader place = document_.at("nodes")[index];
        if (node.mesh >= 0) read_mesh(static_cast<size_t>(node.mesh), place, transform);
        if (node.camera >= 0) read_camera(static_cast<size_t>(node.camera), node.name, transform);
        if (place.has("extensions") && place.at("extensions").has("KHR_lights_punctual"))
            add_light(transformed(node_light(file_, document_, place), transform));
        if (node.skin >= 0) ++skins_;
    }

    void add_light(Light light) {
        light.name = unique_light_name(scene_, light.name);
        scene_.lights.push_back(std::move(light));
    }

    void read_mesh(size_t mesh_index, const JsonReader& node, const dmat4& transform) {
        const tinygltf::Mesh& mesh = model_.meshes[mesh_index];
        std::string name = node.has("name") && node.at("name").value().is_string() ? node.at("name").text() : "";
        if (name.empty()) name = mesh.name.empty() ? fmt::format("mesh-{}", mesh_index) : mesh.name;
        for (size_t i = 0; i < mesh.primitives.size(); ++i) {
            const tinygltf::Primitive& primitive = mesh.primitives[i];
            const std::string place = fmt::format("meshes[{}].primitives[{}]", mesh_index, i);
            if (!primitive.targets.empty()) ++morphed_;
            const int mode = primitive.mode < 0 ? TINYGLTF_MODE_TRIANGLES : primitive.mode;
            if (mode < TINYGLTF_MODE_TRIANGLES) {
                ++points_and_lines_;
                continue;
            }
            const std::string object = mesh.primitives.size() == 1 ? name : fmt::format("{}.{}", name, i);
            add_mesh_object(object, read_primitive(file_, primitive, place), transform,
                            material_index(primitive.material), node, place);
        }
    }

    void add_mesh_object(const std::string& name, const MeshData& mesh, const dmat4& transform, std::uint32_t material,
                         const JsonReader& node, const std::string& place) {
        try {
            add_object(scene_, name, mesh, transform, material);
        } catch (const InputError& error) {
            throw InputError(one_line(path_ + ": " + place + ": " + error.what()));
        }
        Object& object = scene_.objects.back();
        const vec3 emission = scene_.materials[material].emission;
        // Written by export_glb: the surface of a light that has a node of its own.
        if (node.has("extras") && node.at("extras").has("light_source")) {
            object.light_source = node.at("extras").at("light_source").boolean();
            return;
        }
        if (std::max({emission.x, emission.y, emission.z}) <= 0.0f) return;
        if (node.has("extras") && node.at("extras").has("mesh_light") && node.at("extras").at("mesh_light").boolean()) {
            add_mesh_light(scene_, object);
        } else if (std::optional<Light> light = quad_light(scene_, object)) {
            object.light_source = true;
            light->name = name;
            add_light(std::move(*light));
        } else {
            warn(fmt::format("'{}' is emissive but not a rectangle of two triangles, so it is seen but gives no light "
                             "(extras.mesh_light of its node would make it one)",
                             name));
        }
    }

    void read_camera(size_t index, const std::string& node_name, const dmat4& transform) {
        const tinygltf::Camera& source = model_.cameras[index];
        Camera camera;
        camera.forward = {0, 0, -1};
        camera.name = !node_name.empty() ? node_name : !source.name.empty() ? source.name : "camera";
        double near_plane = source.perspective.znear, far_plane = source.perspective.zfar;
        if (source.type == "orthographic") {
            camera.orthographic = true;
            camera.view_height = static_cast<float>(2.0 * std::abs(source.orthographic.ymag));
            near_plane = source.orthographic.znear, far_plane = source.orthographic.zfar;
        } else {
            camera.vertical_fov = static_cast<float>(source.perspective.yfov);
        }
        const bool sensible = camera.orthographic ? camera.view_height > 0.0f && camera.view_height < infinity
                                                  : camera.vertical_fov > 0.0f && camera.vertical_fov < 3.1415f;
        if (!sensible) {
            warn(fmt::format("cameras[{}] has no sensible field of view and is left out", index));
            return;
        }
        camera.near_plane = static_cast<float>(near_plane);
        camera.far_plane = static_cast<float>(far_plane); // 0 where absent: settled by finish_scene
        camera = transformed(camera, transform);
        camera.name = unique_camera_name(scene_, camera.name);
        scene_.cameras.push_back(camera);
    }

    void warn_about_leftovers() {
        const auto report = [&](int count, const char* what) {
            if (count > 0) warn(fmt::format("{} {}", count, what));
        };
        report(points_and_lines_, "primitives of points or lines are left out");
        report(transparent_materials_, "materials with alphaMode MASK or BLEND are treated as opaque");
        report(other_texture_coordinates_,
               "base colour textures use another set than TEXCOORD_0, which is used instead");
        report(emissive_textures_, "emissive textures are left out; the emissive factor counts");
        report(skins_, "skinned nodes are shown in their bind pose");
        report(morphed_, "primitives with morph targets are shown without them");
        for (const std::string& extension : model_.extensionsUsed)
            if (extension == "KHR_texture_transform" || extension == "EXT_mesh_gpu_instancing")
                warn("the extension " + extension + " is not supported and has no effect");
    }

    const tinygltf::Model& model_;
    const JsonReader& document_;
    std::string path_;
    GltfFile file_;
    Scene scene_;
    int default_material_ = -1;
    int points_and_lines_ = 0, transparent_materials_ = 0, other_texture_coordinates_ = 0, emissive_textures_ = 0,
        skins_ = 0, morphed_ = 0;
};

} // namespace

Scene load_gltf(const std::string& path) {
    const std::string bytes = read_file(path);
    const bool binary = is_glb(bytes) || path.ends_with(".glb") || path.ends_with(".GLB");
    const nlohmann::json parsed = parse_json(binary ? glb_json(bytes, path) : std::string_view(bytes), path);
    const JsonReader document(parsed, path);
    check_gltf(document);
    ImageLoading loading{used_images(document), {}};
    const tinygltf::Model model = parse_model(bytes, binary, path, loading);
    return Loader(model, document, path).load(loading.warnings);
}

} // namespace gnomon
