#include <algorithm>

#include <fmt/format.h>

#include "techniques/all.h"

namespace gnomon {

std::span<const Entry> techniques() {
    static const std::vector<Entry> entries = {
        sm_entry(),        pcf_entry(),      vsm_entry(),       smsr_entry(),      rbsm_cons_entry(), rbsm_nonc_entry(),
        rbsm_filt_entry(), rpcf_entry(),     rpcf_opt_entry(),  rpcf_hard_entry(), edtsm_entry(),     pcss_entry(),
        sv_zpass_entry(),  sv_zfail_entry(), raytraced_entry(), truth_entry(),
    };
    return entries;
}

const Entry& find_technique(const std::string& id) {
    const auto all = techniques();
    const auto found = std::find_if(all.begin(), all.end(), [&](const Entry& entry) { return entry.info.id == id; });
    if (found != all.end()) return *found;
    std::vector<std::string> ids;
    for (const Entry& entry : all) ids.push_back(entry.info.id);
    throw UsageError(
        fmt::format("there is no technique '{}'{} (gnomon list techniques shows them)", id, did_you_mean(id, ids)));
}

const char* technique_kind_name(TechniqueKind kind) {
    switch (kind) {
    case TechniqueKind::Hard:
        return "hard";
    case TechniqueKind::Filtered:
        return "filtered";
    case TechniqueKind::Soft:
        return "soft";
    case TechniqueKind::Accurate:
        return "accurate";
    }
    return "";
}

void check_support(const Entry& entry, const Light& light) {
    if (!(entry.info.lights & bit(light.type)))
        throw UsageError(fmt::format("technique '{}' does not support the {} light '{}'; it supports {}", entry.info.id,
                                     light_type_name(light.type), light.name,
                                     fmt::join(light_type_names(entry.info.lights), ", ")));
}

Visibility run_technique(const Entry& entry, Technique& technique, Frame& frame, const Light& light) {
    check_support(entry, light);
    return technique.shade(frame, light);
}

} // namespace gnomon
