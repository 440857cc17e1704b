#pragma once
// A sequence of frames against a sequence of truths, along a path of the camera or of the light: the metrics of each
// frame, pooled, and how the error changes at one receiver from frame to frame. A flickering error is seen where a
// constant one of the same size is not.

#include <memory>
#include <string>
#include <vector>

#include "eval/compare.h"

namespace gnomon {

struct SequenceComparison {
    struct Frame {
        std::string name;
        Comparison comparison;
    };
    std::vector<Frame> frames;
    // Over all frames: counts are sums, metrics are pooled as over channels, weighted by pixels; the metrics of domain
    // Sequence are here alone.
    Comparison whole;
};

// Takes frames in their order, one pair in memory at a time.
class SequenceComparer {
public:
    explicit SequenceComparer(CompareOptions options); // its names are those of the sequences
    ~SequenceComparer();

    // Throws as compare() does. The layers P.X, P.Y, P.Z of the reference, or else of the test, and its attribute
    // worldToNDC say where the frame before shows a receiver; without them it is the same pixel. `mask` is 1 in, 0 out,
    // or empty.
    void add(const std::string& name, const std::string& test_name, const ChannelImage& test,
             const std::string& reference_name, const ChannelImage& reference, Image<std::uint8_t> mask = {});

    SequenceComparison finish() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

// As comparison_json of the whole, and "frames": [{"frame", "test", "reference", "pixels", "masked", "missing",
// "metrics"}].
nlohmann::ordered_json sequence_json(const SequenceComparison& sequence);

} // namespace gnomon
