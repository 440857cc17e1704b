#pragma once
// Which instruction set the kernels use: the best that the machine has, or the one that the environment variable
// GNOMON_ISA=avx512|avx2|plain forces.

#include <hwy/highway.h>

namespace gnomon::detail {

// Highway's target of the forced instruction set, 0 where none is forced. Throws UsageError where GNOMON_ISA names
// none, or one that this machine lacks.
std::int64_t forced_target();

// What a dispatch function answers for the chosen instruction set. Call it once and keep the answer.
template <class Dispatch> auto for_chosen_isa(const Dispatch& dispatch) {
    const std::int64_t target = forced_target();
    if (!target) return dispatch();
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    const auto answer = dispatch();
    hwy::SetSupportedTargetsForTest(0);
    return answer;
}

} // namespace gnomon::detail
