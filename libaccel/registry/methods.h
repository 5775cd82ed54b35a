// The one list of methods.
//
// To add a traverser: write one header in trace/ (one in packet/, if it traces whole batches), include it and add one line
// here. The command lines, the conformance and differential tests, the benchmarks, the SIMT model and the CUDA kernels all
// iterate over this list. The build reads it too (cmake/AccelMethods.cmake) and compiles each method by itself: a line is
// Method<Builder, Traverser>, and both are names that a header included here declares.
#pragma once

#include "libaccel/build/binned_sah.h"
#include "libaccel/build/coded_wide_sbvh.h"
#include "libaccel/build/fast_wide_bvh.h"
#include "libaccel/build/grid.h"
#include "libaccel/build/instances.h"
#include "libaccel/build/kdtree_sah.h"
#include "libaccel/build/sbvh.h"
#include "libaccel/build/triangle_list.h"
#include "libaccel/build/wide_instances.h"
#include "libaccel/build/wide_sbvh.h"
#include "libaccel/core/type_list.h"
#include "libaccel/packet/bvh2_breadth_first.h"
#include "libaccel/packet/bvh8_stream.h"
#include "libaccel/registry/method.h"
#include "libaccel/trace/brute_force.h"
#include "libaccel/trace/bvh2_hash.h"
#include "libaccel/trace/bvh2_parent.h"
#include "libaccel/trace/bvh2_restart_trail.h"
#include "libaccel/trace/bvh2_sibling.h"
#include "libaccel/trace/bvh2_skip.h"
#include "libaccel/trace/bvh2_stack.h"
#include "libaccel/trace/bvh2_uncle.h"
#include "libaccel/trace/bvh8_instances.h"
#include "libaccel/trace/bvh8_ordered.h"
#include "libaccel/trace/grid_dda.h"
#include "libaccel/trace/instances_hash.h"
#include "libaccel/trace/instances_stack.h"
#include "libaccel/trace/kdtree_backtrack.h"
#include "libaccel/trace/kdtree_restart.h"
#include "libaccel/trace/kdtree_ropes.h"
#include "libaccel/trace/kdtree_short_stack.h"
#include "libaccel/trace/kdtree_stack.h"

namespace accel {

using Methods = TypeList<                         //
    Method<ListBuilder, BruteForce>,              // brute/loop
    Method<BinnedSah, Bvh2Stack>,                 // bvh/stack
    Method<Sbvh, Bvh2Stack>,                      // sbvh/stack
    Method<Sbvh, Bvh2Hash>,                       // sbvh/hash
    Method<Sbvh, Bvh2Uncle>,                      // sbvh/uncle
    Method<Sbvh, Bvh2Sibling>,                    // sbvh/sibling
    Method<Sbvh, Bvh2Parent>,                     // sbvh/parent
    Method<Sbvh, Bvh2RestartTrail>,               // sbvh/restart-trail
    Method<Sbvh, Bvh2Skip>,                       // sbvh/skip
    Method<Sbvh, Bvh2SkipOctant>,                 // sbvh/skip-octant
    Method<BinnedSah, Bvh2BreadthFirst>,          // bvh/breadth-first
    Method<Sbvh, Bvh2BreadthFirst>,               // sbvh/breadth-first
    Method<WideSbvh, Bvh8Ordered>,                // bvh8/ordered
    Method<WideSbvh, Bvh8Stream>,                 // bvh8/stream
    Method<FastWideBvh, Bvh8Stream>,              // bvh8-fast/stream
    Method<WideSbvh, Bvh8OrderedNaive>,           // bvh8/ordered-naive
    Method<WideSbvh, Bvh8OrderedFused>,           // bvh8/ordered-fma
    Method<HalfWideSbvh, Bvh8HalfOrdered>,        // bvh8-half/ordered
    Method<ByteWideSbvh, Bvh8ByteOrdered>,        // bvh8-byte/ordered
    Method<CompactWideSbvh, Bvh8CompactOrdered>,  // bvh8-compact/ordered
    Method<GridBuilder, GridDda>,                 // grid/dda
    Method<KdTreeSah, KdTreeStack>,               // kdtree/stack
    Method<KdTreeSah, KdTreeRestart>,             // kdtree/restart
    Method<KdTreeSah, KdTreeBacktrack>,           // kdtree/backtrack
    Method<KdTreeSah, KdTreeShortStack>,          // kdtree/short-stack
    Method<KdTreeSah, KdTreeRopes>,               // kdtree/ropes
    Method<InstanceBuilder, InstancesStack>,      // instances/stack
    Method<InstanceBuilder, InstancesHash>,       // instances/hash
    Method<WideInstances, Bvh8Instances>,         // bvh8-instances/ordered
    Method<WideInstances, Bvh8InstancesStream>    // bvh8-instances/stream
    >;

}  // namespace accel
