// The methods that the emulated kernels are tested with.
//
// That answers are right for every method is a property of the traversers, which the conformance tests and, on a device,
// unit/exec/cuda_test.cpp look at. The kernels must serve whatever a traverser may do, so there is one here for each:
//
//   brute/loop        has leaves only: never descends, never backtracks
//   sbvh/stack        keeps a stack beside its state
//   grid/dda          goes on downwards after a leaf, without backtracking
//   kdtree/backtrack  backtracks step by step, and reads extra arrays
//
// To compile the kernels for a method takes about as long as to compile the method.
#pragma once

#include "libaccel/build/grid.h"
#include "libaccel/build/kdtree_sah.h"
#include "libaccel/build/sbvh.h"
#include "libaccel/build/triangle_list.h"
#include "libaccel/core/type_list.h"
#include "libaccel/registry/method.h"
#include "libaccel/trace/brute_force.h"
#include "libaccel/trace/bvh2_stack.h"
#include "libaccel/trace/grid_dda.h"
#include "libaccel/trace/kdtree_backtrack.h"

namespace accel {

using KernelMethods = TypeList<Method<ListBuilder, BruteForce>, Method<Sbvh, Bvh2Stack>, Method<GridBuilder, GridDda>,
                               Method<KdTreeSah, KdTreeBacktrack>>;

}  // namespace accel
