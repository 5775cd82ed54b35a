// Builds a KdTree top down with the surface-area heuristic over all planes: Wald and Havran 2006, "On building fast kd-trees
// for ray tracing, and on doing that in O(N log N)".
//
// Triangles are clipped to cells ("perfect" splits, section 5.3) and padded, so that traversers need no epsilon: padding.h says
// why, kdtree_split.h how. A node becomes a leaf where no plane promises less than the cost of testing all its triangles, where
// it has no level left, or where all such planes would make more references than its share. Deviation: where a leaf would be
// dear, it becomes one only if some more planes do not pay either (kdtree_costs.h).
//
// Deviations: one list of events an axis, and no planar events, since padded triangles are never flat; references are bounded.
//
// Costs: kdtree_costs.h. With the 8 to 1 of Foley and Sugerman 2005, rays take up to 1.5 times as long.
//
// Invariants: a triangle is in every leaf within pad of it; depth <= 8 + 1.3 log2 n (section 3.3), max_depth and kKdStackSize;
// references <= max_references a triangle. The same bytes for any number of threads. O(n log n) for the n references that there
// are in the end. Memory: some 100 bytes for each reference of the nodes in work, which are those along one path a thread.
#pragma once

#include "libaccel/build/builder.h"
#include "libaccel/build/kdtree_costs.h"
#include "libaccel/structure/kdtree.h"

namespace accel {

struct KdTreeSah {
  static constexpr const char* kName = "kdtree";
  using Structure = KdTree;
  static Result<Built<KdTree>> build(const TriangleMesh& mesh, const BuildOptions& options);

  // With a cost model of the caller's in place of the options': for those who reproduce papers.
  static Result<Built<KdTree>> build(const TriangleMesh& mesh, const BuildOptions& options, const KdCosts& costs);
};

}  // namespace accel
