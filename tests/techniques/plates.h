#pragma once
// Sheets over a floor under a light straight above: maps whose texels are known, and filters whose answers are closed
// forms. Places on the map are in texels from its middle: u along x, v along −z.

#include <cmath>
#include <vector>

#include "techniques/map/light_view.h"
#include "tests/techniques/shading.h"

namespace gnomon_tests {

struct Sheet {
    float height;                        // metres over the floor
    std::vector<gnomon::vec2> corners{}; // x, z in texels, any winding; none: the whole floor
};

// A floor of `texels` texels a side, 0.1 m each, whose map of size=texels meets the sheets' edges at texel borders, and
// a camera just under `eye` metres that sees `view` texels of it upright.
class PlatesScene {
public:
    static constexpr float texel = 0.1f;

    PlatesScene(int texels, std::vector<Sheet> sheets, float eye, float view, int pixels = 256) {
        using namespace gnomon;
        // The view of a directional light is a thousandth wider than what it shows.
        const float half = 0.5f * static_cast<float>(texels) * texel / 1.001f;
        scene_.materials.push_back({});
        add_sheet(0.0f, {{-half, -half}, {half, -half}, {half, half}, {-half, half}});
        for (const Sheet& sheet : sheets) {
            std::vector<vec2> corners = sheet.corners;
            for (vec2& corner : corners) corner = glm::clamp(corner * texel, -half, half);
            if (corners.empty()) corners = {{-half, -half}, {half, -half}, {half, half}, {-half, half}};
            add_sheet(sheet.height, corners);
        }
        for (const vec3& p : scene_.positions) scene_.bounds.extend(p);
        Camera camera = look_at({0.0f, eye, 0.0f}, {0.0f, 0.0f, 0.0f}, 1.0f);
        camera.orthographic = true;
        camera.view_height = view * texel;
        camera.near_plane = 0.01f;
        camera.far_plane = 2.0f * eye;
        scene_.cameras.push_back(camera);
        sun_.name = "sun";
        sun_.type = LightType::Directional;
        sun_.direction = {0, -1, 0};
        frame_ = std::make_unique<Frame>(scene_, scene_.cameras[0], pixels, pixels);
    }

    gnomon::Frame& frame() { return *frame_; }
    const gnomon::Light& sun() const { return sun_; }
    gnomon::Visibility shade(const std::string& text) { return gnomon_tests::shade(*frame_, sun_, text); }

    // Texels from the middle of the map.
    gnomon::vec2 place(int x, int y) const {
        const gnomon::vec3 p = frame_->receivers()(x, y).position;
        return {p.x / texel, -p.z / texel};
    }
    // Linear depth of what lies at that height.
    double depth_of(float height) const {
        const auto views = gnomon::light_views(*frame_, sun_, {});
        return static_cast<double>(views[0].linear_depth({0.0f, height, 0.0f}));
    }

private:
    void add_sheet(float y, const std::vector<gnomon::vec2>& corners) {
        gnomon::MeshData mesh;
        for (const gnomon::vec2 c : corners) mesh.positions.push_back({c.x, y, c.y});
        for (std::uint32_t i = 2; i < corners.size(); ++i) mesh.triangles.push_back({0, i, i - 1});
        add_object(scene_, "sheet", mesh, gnomon::dmat4(1.0), 0);
    }

    gnomon::Scene scene_;
    gnomon::Light sun_;
    std::unique_ptr<gnomon::Frame> frame_;
};

// The half of the floor with u < 0.
inline std::vector<gnomon::vec2> left_half() { return {{-999, -999}, {0, -999}, {0, 999}, {-999, 999}}; }

// Share of a filter about u that lies left of 0: weights of whole texels under a bilinear look-up.
inline double share_on_the_left(double u, const std::vector<float>& weights) {
    const double corner = u - 0.5, low = std::floor(corner), f = corner - low;
    const int reach = static_cast<int>(weights.size()) / 2;
    const auto at_texel = [&](int texel) { // texels below 0 are on the left
        double sum = 0;
        for (int k = 0; k < static_cast<int>(weights.size()); ++k)
            if (texel + k - reach < 0) sum += static_cast<double>(weights[static_cast<size_t>(k)]);
        return sum;
    };
    return at_texel(static_cast<int>(low)) * (1.0 - f) + at_texel(static_cast<int>(low) + 1) * f;
}

} // namespace gnomon_tests
