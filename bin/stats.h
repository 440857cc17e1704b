#pragma once
// What a run cost, as data: `render --stats`. Every time in it is a key called "seconds", so that the rest can be
// compared between runs; "peak_resident_bytes" is the machine's and varies too.

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/scene.h"
#include "raster/counters.h"

namespace gnomon {

// One technique on one light.
struct TechniqueStats {
    std::string label, id, light;
    nlohmann::json parameters;
    double seconds = 0; // without building what techniques share (adjacency, Embree)
    PassLog log;
};

struct StepStats {
    std::string name;
    double seconds = 0;
};

struct RunStats {
    std::string scene;
    size_t triangles = 0, vertices = 0, objects = 0;
    int width = 0, height = 0;
    std::string camera;
    float exposure = 1;
    PassLog gbuffer;
    double gbuffer_seconds = 0;
    std::vector<TechniqueStats> techniques;
    std::vector<StepStats> steps;
};

nlohmann::ordered_json counters_json(const PassCounters& counters); // all but name and seconds
nlohmann::ordered_json passes_json(const PassLog& log);
nlohmann::ordered_json stats_json(const RunStats& stats);

// FILE.json, or standard output for "-".
void write_json(const std::string& target, const nlohmann::ordered_json& json);

// The most physical memory that the program held at once, since it began or since the last reset, as far as the system
// lets that be reset.
std::int64_t peak_resident_bytes();
void reset_peak_resident_bytes();

class Stopwatch {
public:
    double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

} // namespace gnomon
