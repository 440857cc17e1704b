#pragma once
// Occlusion queries: how many fragments of a pass went through all tests while the query was open. Exact and the same
// for any number of threads, so that a technique may decide on it. Queries of a pass may overlap and nest; one that is
// given its outer query carries its name: 'lights/3'.

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "raster/counters.h"

namespace gnomon {

class OcclusionQuery {
public:
    // Opens. The pass must outlive the query, or end() must come before.
    explicit OcclusionQuery(Pass& pass, std::string name = {})
        : counters_(&pass.counters()), name_(std::move(name)), begin_(counters_->fragments_passed) {}
    OcclusionQuery(Pass& pass, const OcclusionQuery& outer, const std::string& name)
        : OcclusionQuery(pass, outer.name_.empty() ? name : outer.name_ + '/' + name) {}

    // Closes: what is drawn afterwards no longer counts. Returns the result.
    std::int64_t end() {
        if (!end_) end_ = counters_->fragments_passed;
        return *end_ - begin_;
    }
    // Between draws the result so far, after end() the result.
    std::int64_t samples_passed() const { return (end_ ? *end_ : counters_->fragments_passed) - begin_; }
    bool any_samples_passed() const { return samples_passed() > 0; }
    const std::string& name() const { return name_; }

private:
    const PassCounters* counters_;
    std::string name_;
    std::int64_t begin_;
    std::optional<std::int64_t> end_;
};

} // namespace gnomon
