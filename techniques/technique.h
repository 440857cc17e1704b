#pragma once
// What a shadow technique is, and how the program knows about it. One file a technique; one table of parameters; one
// line in registry.cpp. docs/adding-a-technique.md shows it step by step.

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/light.h"
#include "core/parameters.h"
#include "techniques/frame.h"

namespace gnomon {

// An image that a technique wants to show besides its answer: its shadow map, its penumbra widths.
struct NamedImage {
    std::string name;
    Image<float> values;
};

// A technique's answer for one light: the fraction of the light that each receiver sees, 1 lit, 0 umbra.
struct Visibility {
    Image<float> values;
    std::optional<Image<vec3>> radiance; // W/(m² sr), only from techniques that integrate it themselves
    std::vector<NamedImage> debug;
    std::vector<NamedImage> layers = {}; // of the frame's size, always written beside the answer: its error bar
};

// Lives for a sequence of frames; only progressive techniques keep anything between them.
class Technique {
public:
    virtual ~Technique() = default;
    virtual Visibility shade(Frame& frame, const Light& light) = 0;
};

enum class TechniqueKind { Hard, Filtered, Soft, Accurate };
const char* technique_kind_name(TechniqueKind kind); // "hard", "filtered", "soft", "accurate"

// What `gnomon list techniques` knows.
struct TechniqueInfo {
    std::string id;     // as in technique-ids.txt, "pcf"
    std::string title;  // "percentage-closer filtering"
    std::string family; // "shadow map", "shadow volume", "ray tracing", …
    TechniqueKind kind = TechniqueKind::Hard;
    std::string paper; // "Reeves, Salesin, Cook 1987; Macedo 2018"
    LightTypes lights = all_lights;
    // What `gnomon help` and the page of techniques tell, each a line or a few; a test asks all of them of every entry.
    std::string section = "";   // where it is described: "Macedo 2018, 3.2, algorithm 1"
    std::string equations = ""; // "(3.3), (3.4), (3.9)"
    std::string strengths = ""; // what it is good at
    std::string artifacts = ""; // what is known to go wrong, and where
    int version = 1; // raised whenever the technique answers differently, so that studies compute its cells anew
};

struct Entry {
    TechniqueInfo info;
    std::vector<ParameterInfo> parameters;
    std::function<std::unique_ptr<Technique>(const ParameterText&)> make; // throws UsageError
};

// The entry of technique class T, constructed from its Params, which come from its table of fields.
template <class T, class Params, class Table> Entry make_entry(TechniqueInfo info, const Table& table) {
    Entry entry;
    for (const BoundParameter& parameter : bind<Params>(table)) entry.parameters.push_back(parameter.info);
    entry.make = [table, owner = "technique '" + info.id + "'"](const ParameterText& text) {
        return std::make_unique<T>(parse_parameters<Params>(table, text, owner));
    };
    entry.info = std::move(info);
    return entry;
}

// Every technique there is, in the order they are listed.
std::span<const Entry> techniques();

// Throws UsageError with the nearest known id.
const Entry& find_technique(const std::string& id);

// Throws UsageError naming what is supported where the light's type is not.
void check_support(const Entry& entry, const Light& light);

// Checks that the light's type is among those supported, then shades. Throws UsageError naming what is supported.
Visibility run_technique(const Entry& entry, Technique& technique, Frame& frame, const Light& light);

} // namespace gnomon
