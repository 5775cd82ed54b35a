// Builds a Bvh8 in as little time as there is between two frames: for scenes that move.
//
// Triangles are sorted along a Z-curve (build/curve_order.h), cut into leaves of a block each (build/curve_leaves.h), which are
// merged into a binary tree bottom up (build/cluster_tree.h) and collapsed (build/collapse_clusters.h). All of it in parallel.
//
// Invariants: every triangle is in exactly one leaf; depth <= options.max_depth. Where the tree would be deeper, as over chains
// of triangles, each twice as large as the one before, it gives way to a balanced one, of equal parts of the curve. Of the
// options, bins say nothing here, and costs only in the collapse; leaves have max_leaf_size triangles at most, or four, which are
// tested at once. O(n).
#pragma once

#include "libaccel/build/builder.h"
#include "libaccel/structure/bvh8.h"

namespace accel {

struct FastWideBvh {
  static constexpr const char* kName = "bvh8-fast";
  using Structure = Bvh8;
  static Result<Built<Bvh8>> build(const TriangleMesh& mesh, const BuildOptions& options);
};

}  // namespace accel
