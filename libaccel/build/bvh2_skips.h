// Annotates a Bvh2 with skip pointers: Smits 1998, "Efficiency Issues for Ray Tracing"; for each octant of ray directions an
// order of its own, as Boulos and Haines 2006, "Ray-Box Sorting".
//
// In the one order child 0 comes first, which builders make the larger one. In an octant's order the child comes first whose
// centre lies farther back along the octant's diagonal.
#pragma once

#include "libaccel/structure/bvh2.h"

namespace accel {

// Set bvh.skips and bvh.octant_skips. O(nodes); parallel in the calling thread's arena; throw std::bad_alloc.
void add_skips(Bvh2& bvh);
void add_octant_skips(Bvh2& bvh);

}  // namespace accel
