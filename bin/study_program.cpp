#include "bin/study_program.h"

#include <filesystem>
#include <optional>

#include "bin/render_options.h"
#include "bin/shade.h"
#include "bin/stats.h"
#include "bin/text.h"
#include "raytrace/truth_state.h"

namespace gnomon {
namespace {

constexpr double seconds_between_saves = 5;

struct ViewRequest {
    SceneRequest scene;
    ivec2 size{1, 1};
    Primary primary = Primary::Raster;
};

ViewRequest read_view(const StudyView& view, bool quiet) {
    SceneOptions options;
    options.scene = view.scene;
    options.quiet = quiet;
    const auto take = [](const ParameterText& from, const char* name, std::string& to) {
        if (const auto found = from.find(name); found != from.end()) to = found->second;
    };
    take(view.camera, "camera", options.camera);
    take(view.camera, "look-from", options.look_from);
    take(view.camera, "look-at", options.look_at);
    take(view.camera, "fov", options.fov);
    take(view.light, "light", options.light);
    take(view.light, "light-aim", options.light_aim);
    take(view.light, "light-size", options.light_size);
    take(view.light, "light-intensity", options.light_intensity);
    return {read_scene_options(options), parse_size(view.size, "the size"), parse_primary(view.primary, "primary")};
}

// What distinguishes frames.
bool same_view(const StudyView& a, const StudyView& b) {
    return a.scene == b.scene && a.camera == b.camera && a.light == b.light && a.size == b.size &&
           a.primary == b.primary;
}

class CellRenderer {
public:
    explicit CellRenderer(bool quiet) : quiet_(quiet) {}

    StudyImage render(const StudyView& view, const StudyChoice& choice, const std::string& state_path) {
        reset_peak_resident_bytes();
        set_view(view);
        const TechniqueRequest technique{&find_technique(choice.id), choice.text, false};
        const std::unique_ptr<TruthState> state = open_truth_state(state_path);
        frame_->truth_run.state = state.get();
        StudyImage answer = shade(technique);
        frame_->truth_run.state = nullptr;
        if (state) state->remove();
        answer.peak_bytes = peak_resident_bytes();
        return answer;
    }

private:
    void set_view(const StudyView& view) {
        if (frame_ && same_view(view, view_)) return;
        const ViewRequest request = read_view(view, quiet_);
        frame_.reset();
        if (stage_ && view.scene == view_.scene) {
            Scene scene = std::move(stage_->scene);
            stage_.reset();
            stage_ = make_stage(std::move(scene), request.scene);
        } else {
            stage_.reset();
            stage_ = load_stage(request.scene);
        }
        view_ = view;
        frame_ =
            std::make_unique<Frame>(stage_->scene, stage_->camera, request.size.x, request.size.y, request.primary);
    }

    // A state that cannot be used is a broken one, since its name stands for all that the truth depends on.
    static std::unique_ptr<TruthState> open_truth_state(const std::string& path) {
        if (path.empty()) return nullptr;
        const nlohmann::ordered_json identity = {{"truth", std::filesystem::path(path).filename().string()}};
        try {
            return std::make_unique<TruthState>(path, identity, true, seconds_between_saves);
        } catch (const InputError&) {
            std::filesystem::remove(path);
            return std::make_unique<TruthState>(path, identity, true, seconds_between_saves);
        }
    }

    static void add_pass(StudyImage& answer, const std::string& light, const std::string& name,
                         const PassCounters& counters) {
        nlohmann::ordered_json row = {{"light", light}, {"name", name}};
        answer.pass_seconds.push_back(row);
        answer.pass_seconds.back()["seconds"] = counters.seconds;
        row.update(counters_json(counters));
        answer.passes.push_back(std::move(row));
    }

    StudyImage shade(const TechniqueRequest& technique) {
        StudyImage answer;
        std::vector<LitImage> images;
        PassCounters totals;
        std::int64_t target_bytes = 0;
        answer.passes = answer.pass_seconds = nlohmann::ordered_json::array();
        for (const PassCounters& pass : frame_->gbuffer_log().passes) add_pass(answer, "", "G-buffer", pass);
        for (size_t light = 0; light < stage_->lights.size(); ++light) {
            Shaded shaded = shade_light(*frame_, *stage_, light, technique, technique.entry->info.id, false);
            for (const PassCounters& pass : shaded.stats.log.passes) {
                totals.add(pass);
                add_pass(answer, shaded.stats.light, pass.name, pass);
            }
            target_bytes = std::max(target_bytes, shaded.stats.log.memory->peak());
            answer.seconds += shaded.stats.seconds;
            images.push_back(std::move(shaded.image));
        }
        answer.counters = counters_json(totals);
        answer.counters["target_bytes"] = target_bytes;
        answer.image.width = frame_->width(), answer.image.height = frame_->height();
        answer.image.attributes = image_attributes(*stage_, *frame_, technique);
        add_visibility(answer.image, *frame_, stage_->lights, images);
        return answer;
    }

    bool quiet_;
    StudyView view_;
    std::optional<Stage> stage_;
    std::unique_ptr<Frame> frame_; // of the stage's scene
};

} // namespace

StudyProgram make_study_program(bool quiet) {
    StudyProgram program;
    program.version = GNOMON_VERSION;
    for (const Entry& entry : techniques())
        program.techniques.push_back({entry.info.id, entry.info.version, entry.parameters,
                                      [&entry](const ParameterText& text) { entry.make(text); }});
    const nlohmann::ordered_json counted = counters_json({});
    for (const auto& item : counted.items()) program.counters.push_back(item.key());
    program.counters.emplace_back("target_bytes");
    program.check_view = [](const StudyView& view) { read_view(view, true); };
    const auto renderer = std::make_shared<CellRenderer>(quiet);
    program.render = [renderer](const StudyView& view, const StudyChoice& choice, const std::string& state) {
        return renderer->render(view, choice, state);
    };
    return program;
}

} // namespace gnomon
