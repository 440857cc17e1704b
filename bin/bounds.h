#pragma once
// The bounds that `gnomon compare` tests its metrics against, from the command line and from files.

#include <string>
#include <vector>

#include "eval/compare.h"

namespace gnomon {

struct Bound {
    std::string metric; // of metrics(), or "missing": the pixels that are left out because a value is not finite
    double value = 0;
    bool above = true; // crossed where the metric is above, else where it is below
};

// METRIC=NUMBER each. Throws UsageError.
void read_bounds(const std::vector<std::string>& texts, bool above, std::vector<Bound>& bounds);

// {"fail_above": {METRIC: NUMBER, …}, "fail_below": {…}}, either may lack. Throws InputError.
void read_bounds_file(const std::string& path, std::vector<Bound>& bounds);

// Throws Error of ExitCode::BoundCrossed with a line that names all that are crossed; InputError for a bound on a
// metric that the comparison lacks.
void check_bounds(const Comparison& comparison, const std::vector<Bound>& bounds);

// Throws UsageError for a name that is no metric's; "all" is fine.
void check_metric(const std::string& id);

// With six digits, or "infinite".
std::string value_text(double value);

} // namespace gnomon
