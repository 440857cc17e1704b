#include "raster/isa.h"

#include <cstdlib>
#include <string_view>

#include <fmt/format.h>

#include "core/error.h"

namespace gnomon::detail {

std::int64_t forced_target() {
    const char* wanted = std::getenv("GNOMON_ISA");
    if (!wanted || !*wanted) return 0;
    const std::string_view name = wanted;
    const std::int64_t baseline = HWY_STATIC_TARGET;
    const std::int64_t target = name == "avx512"  ? HWY_AVX3
                                : name == "avx2"  ? HWY_AVX2
                                : name == "plain" ? baseline
                                                  : 0;
    if (!target) throw UsageError(fmt::format("GNOMON_ISA is '{}', but must be avx512, avx2 or plain", name));
    if (!(hwy::SupportedTargets() & target) && target != baseline)
        throw UsageError(fmt::format("GNOMON_ISA is '{}', which this machine does not have", name));
    return target;
}

} // namespace gnomon::detail
