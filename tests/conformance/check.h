#pragma once
// What the checks of gnomon-conformance share. Each check prints its figures and reports whether its bounds held.

#include <cstdint>
#include <random>
#include <string>

namespace gnomon_conformance {

struct Options {
    double soak = 1; // multiplies the amount of work
    std::uint32_t seed = 1;
    int repeat(int count) const { return count * soak < 1 ? 1 : static_cast<int>(count * soak); }
};

// One line of a check: its name, its figures, and whether they are within bounds.
class Verdict {
public:
    explicit Verdict(std::string check) : check_(std::move(check)) {}
    void figure(const std::string& text);              // for the record, not bounded
    void require(bool holds, const std::string& text); // bounded
    void skip(const std::string& text);                // could not be looked at
    bool held() const { return held_; }

private:
    std::string check_;
    bool held_ = true;
};

inline double fraction(std::int64_t part, std::int64_t whole) {
    return static_cast<double>(part) / static_cast<double>(whole);
}

bool check_coverage(const Options& options);
bool check_stencil(const Options& options);
bool check_meshes(const Options& options);
bool check_clipping(const Options& options);
bool check_depth(const Options& options);
bool check_volumes(const Options& options);
bool check_exact_volumes(const Options& options);
bool check_infinite_volumes(const Options& options);
bool check_states(const Options& options);
bool check_blending(const Options& options);
bool check_lines(const Options& options);
bool check_multisampling(const Options& options);

struct Random {
    std::mt19937 engine;
    explicit Random(std::uint32_t seed) : engine(seed) {}
    std::uint32_t bits() { return static_cast<std::uint32_t>(engine()); }
    int between(int low, int high) { // both included
        return low + static_cast<int>(bits() % static_cast<unsigned>(high - low + 1));
    }
    bool chance(int one_in) { return bits() % static_cast<unsigned>(one_in) == 0; }
    double real(double low, double high) { return low + (high - low) * (bits() * 0x1p-32); }
    template <class Enum> Enum pick(int count) { return static_cast<Enum>(between(0, count - 1)); }
};

} // namespace gnomon_conformance
