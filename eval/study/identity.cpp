#include "eval/study/identity.h"

#include <filesystem>

#include "core/atomic_file.h"
#include "core/builtin/builtin.h"
#include "core/digest.h"
#include "core/scene_files.h"

namespace gnomon {
namespace {

using nlohmann::ordered_json;

// Raised where the same identity would be answered otherwise by what all techniques share: the G-buffer, masks, files.
constexpr int results_version = 1;

ordered_json builtin_identity(const std::string& specification) {
    const Specification parsed = parse_specification(specification.substr(builtin_prefix.size()));
    const BuiltinScene& builtin = find_builtin(parsed.name);
    const Scene scene = builtin.make(parsed.parameters);
    Digest digest;
    digest.add_all(std::span<const vec3>(scene.positions));
    digest.add_all(std::span<const vec3>(scene.normals));
    digest.add_all(std::span<const uvec3>(scene.triangles));
    return {{"name", specification},
            {"parameters", parameters_json(builtin.parameters, parsed.parameters)},
            {"triangles", digest.text()}};
}

ordered_json file_identity(const std::string& path) {
    ordered_json files = ordered_json::object();
    for (const SceneFile& file : scene_files(path)) {
        std::error_code ignored;
        if (!std::filesystem::is_regular_file(file.path, ignored)) {
            files[file.name] = "missing";
            continue;
        }
        Digest digest;
        digest.add_text(read_file(file.path));
        files[file.name] = digest.text();
    }
    return {{"name", std::filesystem::path(path).filename().string()}, {"files", files}};
}

ordered_json choice_identity(const StudyChoice& choice) {
    return {{"id", choice.id}, {"version", choice.version}, {"parameters", choice.parameters}};
}

ordered_json view_identity(const std::string& program_version, const ordered_json& scene, const StudyView& view) {
    return {{"gnomon", program_version}, {"results", results_version}, {"scene", scene},
            {"camera", view.camera},     {"light", view.light},        {"size", view.size},
            {"primary", view.primary}};
}

} // namespace

ordered_json scene_identity(const std::string& specification) {
    return specification.starts_with(builtin_prefix) ? builtin_identity(specification) : file_identity(specification);
}

ordered_json truth_cell_identity(const std::string& program_version, const ordered_json& scene, const StudyView& view,
                                 const StudyChoice& truth) {
    ordered_json identity = view_identity(program_version, scene, view);
    identity["truth"] = choice_identity(truth);
    return identity;
}

ordered_json cell_identity(const std::string& program_version, const ordered_json& scene, const StudyView& view,
                           const StudyChoice& technique, const StudyChoice& truth,
                           const std::vector<std::string>& metrics) {
    ordered_json identity = truth_cell_identity(program_version, scene, view, truth);
    identity["technique"] = choice_identity(technique);
    identity["metrics"] = metrics;
    return identity;
}

std::string identity_hash(const ordered_json& identity) {
    Digest digest;
    digest.add_text(identity.dump(-1, ' ', false, ordered_json::error_handler_t::replace));
    return digest.text();
}

} // namespace gnomon
