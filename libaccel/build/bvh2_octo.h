// Annotates a Bvh2 with an Octo-BVH: Garanzha and Loop 2010, section 3.3; what differs is told in structure/octo_node.h.
#pragma once

#include "libaccel/structure/bvh2.h"

namespace accel {

// Sets bvh.octo. O(nodes); parallel in the calling thread's arena; the same bytes for any number of threads; fails for trees of
// 2^28 nodes or more; throws std::bad_alloc.
Status add_octo(Bvh2& bvh);

}  // namespace accel
