#pragma once
// Memory of passes that is no Target, counted in a MemoryMeter for as long as it lives.

#include <memory>
#include <utility>

#include "raster/counters.h"

namespace gnomon {

class MeteredBytes {
public:
    MeteredBytes() = default;
    MeteredBytes(std::shared_ptr<MemoryMeter> meter, std::int64_t bytes) : meter_(std::move(meter)), bytes_(bytes) {
        if (meter_) meter_->allocate(bytes_);
    }
    ~MeteredBytes() {
        if (meter_) meter_->release(bytes_);
    }
    MeteredBytes(MeteredBytes&& other) noexcept = default; // leaves the other without a meter
    MeteredBytes& operator=(MeteredBytes&& other) noexcept {
        std::swap(meter_, other.meter_);
        std::swap(bytes_, other.bytes_);
        return *this;
    }

private:
    std::shared_ptr<MemoryMeter> meter_;
    std::int64_t bytes_ = 0;
};

} // namespace gnomon
