// Builds a KdTree top down with the surface-area heuristic over all planes: Wald and Havran 2006, "On building fast kd-trees
// for ray tracing, and on doing that in O(N log N)".
//
// Triangles are clipped to cells ("perfect" splits, section 5.3) and padded, so that traversers need no epsilon: kdtree.h says
// why, cell_padding.h how. A node becomes a leaf where no plane promises less than the cost of testing all its triangles, where
// it has no level left, or where every cheaper plane would make more references than its share.
//
// Invariants: a triangle is in every leaf within pad of it; depth <= kKdStackSize; references <= max_references a triangle. The
// same bytes for any number of threads. O(n log n) for the n references that there are in the end. Memory: some 100 bytes for
// each reference of the nodes in work, which are those along one path a thread.
#pragma once

#include "libaccel/build/builder.h"
#include "libaccel/structure/kdtree.h"

namespace accel {

struct KdTreeSah {
  static constexpr const char* kName = "kdtree";
  using Structure = KdTree;
  static Result<Built<KdTree>> build(const TriangleMesh& mesh, const BuildOptions& options);
};

}  // namespace accel
