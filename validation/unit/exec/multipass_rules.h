// The rules by which the multipass executor chooses its next kernel.
#pragma once

#include "libaccel/exec/multipass_schedule.h"

namespace accel::test {

inline constexpr MultipassRule kRules[] = {MultipassRule::delany, MultipassRule::largest_first, MultipassRule::drain};

}  // namespace accel::test
