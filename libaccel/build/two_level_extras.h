// Adds the annotations of a Bvh2 to every tree of two levels (structure/two_level.h).
#pragma once

#include "libaccel/build/builder.h"
#include "libaccel/structure/two_level.h"

namespace accel {

// One note tells of all trees together. Parallel in the calling thread's arena; throws std::bad_alloc.
Status add_extras(TwoLevelBvh& bvh, Bvh2Extras extras, BuildReport& report);

}  // namespace accel
