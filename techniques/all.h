#pragma once
// The entries of all techniques: each is defined at the end of its own file and named once more in registry.cpp.

#include "techniques/technique.h"

namespace gnomon {

Entry sm_entry();
Entry pcf_entry();
Entry vsm_entry();
Entry smsr_entry();
Entry rbsm_cons_entry();
Entry rbsm_nonc_entry();
Entry rbsm_filt_entry();
Entry rpcf_entry();
Entry rpcf_opt_entry();
Entry rpcf_hard_entry();
Entry edtsm_entry();
Entry pcss_entry();
Entry sv_zpass_entry();
Entry sv_zfail_entry();
Entry raytraced_entry();
Entry truth_entry();

} // namespace gnomon
