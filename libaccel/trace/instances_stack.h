// Two levels of ordered traversal with a stack (bvh2_stack.h), one stack a level.
#pragma once

#include "libaccel/trace/bvh2_stack.h"
#include "libaccel/trace/two_level.h"

namespace accel {

template <class Test, Query kQuery>
using InstancesStack = TwoLevel<Bvh2Stack<Test, kQuery>, kQuery>;

}  // namespace accel
