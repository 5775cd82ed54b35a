// Ordered traversal of two levels of eight-wide BVHs (structure/two_level_bvh8.h): trace/bvh8_ordered.h on both.
//
// On CPUs batches are traced by trace/bvh8_instances_simd.h: this is its scalar twin, which names the same hits bit for bit.
#pragma once

#include "libaccel/trace/bvh8_instances_simd.h"
#include "libaccel/trace/bvh8_ordered.h"
#include "libaccel/trace/simd_batch.h"
#include "libaccel/trace/two_level.h"

namespace accel {

template <class Test, Query kQuery>
struct Bvh8Instances : TwoLevel<Bvh8Ordered<Test, kQuery>, kQuery, TwoLevelBvh8View> {
  template <class TraceSingly>
  using Batch = SimdBatch<TwoLevelBvh8View, Bvh8InstancesSimd<Test>, kQuery, TraceSingly>;
};

}  // namespace accel
