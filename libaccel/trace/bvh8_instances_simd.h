// Two levels of eight-wide BVHs by single rays in SIMD lanes, by turns, as trace/bvh8_simd.h has one level. A change of trees,
// into an instance or out of it, is one more kind of step: rays that are at one wait for their instance as others do for a
// node.
//
// What is postponed outside stays on the same stack, below what is postponed in the instance, since t is the same on both
// levels (core/affine.h): a hit in the instance drops instances behind it at once.
#pragma once

#include "libaccel/geometry/watertight.h"
#include "libaccel/structure/two_level_bvh8.h"
#include "libaccel/trace/simd_batch.h"

namespace accel {

// The functions for the best target that the machine has. No tree is deeper than kMostBvh8Depth.
template <class Test>
struct Bvh8InstancesSimd;

template <>
struct Bvh8InstancesSimd<Watertight> {
  static SimdFunctions<TwoLevelBvh8View> functions();
};

}  // namespace accel
