// Annotates a Bvh2 with the perfect hash that maps keys to nodes: Binder and Keller 2016, section 2.2.
//
// Only the keys that the traversal may look up are hashed (HashedKeys in structure/bvh2.h says which and why), unless all are
// asked for, which a traversal that is resumed by its key alone needs. Where there is no such key, there are no tables.
#pragma once

#include "libaccel/build/builder.h"
#include "libaccel/core/result.h"
#include "libaccel/structure/bvh2.h"

namespace accel {

// Notes in the report say what was hashed, how wide keys are, and what was left out. O(nodes) expected; parallel in the calling
// thread's arena; throws std::bad_alloc.
Status add_hash(Bvh2& bvh, HashedKeys which, BuildReport& report);

}  // namespace accel
