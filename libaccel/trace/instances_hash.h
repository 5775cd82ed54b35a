// Two levels of traversal without a stack, with backtracking in constant time (bvh2_hash.h): Binder and Keller 2016, section
// 2.4.
#pragma once

#include "libaccel/trace/bvh2_hash.h"
#include "libaccel/trace/two_level.h"

namespace accel {

template <class Test, Query kQuery>
using InstancesHash = TwoLevel<Bvh2Hash<Test, kQuery>, kQuery>;

}  // namespace accel
