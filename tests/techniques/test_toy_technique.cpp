// A technique added the way docs/adding-a-technique.md shows, and all that follows from its table.

#include <catch2/catch.hpp>

#include <nlohmann/json.hpp>

#include "techniques/all.h"
#include "techniques/map/shadow_map.h"
#include "tests/techniques/shading.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

struct TwoTapParams : ShadowMapParams {
    float distance = 1.0f;
};
constexpr auto two_tap_fields = join(
    shadow_map_fields,
    fields(field("distance", &TwoTapParams::distance, 0, 64, "texels", "between the two taps", "Author Year, eq. 1")));

class TwoTap : public Technique {
public:
    explicit TwoTap(TwoTapParams params) : params_(params) {}

    Visibility shade(Frame& frame, const Light& light) override {
        const ShadowMap map = draw_shadow_map(frame, light, params_);
        Visibility visibility;
        visibility.values = for_each_receiver(frame, "look-up", [&](const Receiver& receiver, Pixel& pixel) {
            const MapPoint point = map_point(map, light, receiver);
            if (point.lit || point.dark) return point.lit ? 1.0f : 0.0f;
            return percentage_closer(map, point, 2, vec2(params_.distance), pixel.counters);
        });
        return visibility;
    }

private:
    TwoTapParams params_;
};

Entry two_tap_entry() {
    return make_entry<TwoTap, TwoTapParams>({.id = "two-tap",
                                             .title = "two by two taps",
                                             .family = "shadow map",
                                             .kind = TechniqueKind::Filtered,
                                             .paper = "Author Year",
                                             .lights = all_lights},
                                            two_tap_fields);
}

} // namespace

TEST_CASE("a technique added as documented is listed, checked and run from its one table") {
    const Entry entry = two_tap_entry();
    CHECK(entry.parameters.back().name == "distance");
    CHECK(parameters_json(entry.parameters, {{"size", "256"}})["size"] == 256);
    CHECK_THROWS_WITH(entry.make({{"distanse", "2"}}),
                      "technique 'two-tap' has no parameter 'distanse'; did you mean 'distance'?");
    CHECK_THROWS_WITH(entry.make({{"distance", "65"}}),
                      "technique 'two-tap': parameter 'distance' is '65', but must be between 0 and 64 texels");

    const Scene scene = box_over_floor();
    Frame frame(scene, scene.cameras[0], 160, 120);
    const Light light = point_light({0, 4, 0});
    const Visibility toy = run_technique(entry, *entry.make({}), frame, light);
    const Visibility pcf = shade(frame, light, "pcf:kernel=2,radius=1,receiver-plane=false");
    CHECK(std::equal(toy.values.values().begin(), toy.values.values().end(), pcf.values.values().begin()));
    CHECK(frame.log().passes.size() == 2);
}

TEST_CASE("the registry's ids are unique and its tables complete") {
    for (const Entry& entry : techniques()) {
        INFO(entry.info.id);
        CHECK(&find_technique(entry.info.id) == &entry);
        CHECK_FALSE(entry.info.title.empty());
        CHECK_FALSE(entry.info.paper.empty());
        CHECK(entry.info.lights != 0);
        for (const ParameterInfo& parameter : entry.parameters) {
            INFO(parameter.name);
            CHECK_FALSE(parameter.help.empty());
            CHECK_NOTHROW(entry.make({{parameter.name, parameter.default_text}}));
            if (!parameter.preset.empty()) CHECK_NOTHROW(entry.make({{parameter.name, parameter.choices.back()}}));
        }
    }
}
