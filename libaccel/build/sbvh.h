// Builds a Bvh2 top down with the surface-area heuristic over object splits and spatial splits.
//
// Stich, Friedrich and Dietrich 2009, "Spatial Splits in Bounding Volume Hierarchies": chopped binning, reference unsplitting,
// and the restriction of spatial splits to nodes whose children would overlap. Deviation: the budget of references is hard, and
// every subtree has its share of it, in proportion to its references; a shared counter would make the tree depend on the tasks'
// order.
//
// Invariants: every triangle is in one leaf or, in parts that cover it, in several; there are at most (1 + max_duplication)
// references a triangle; depth <= options.max_depth. O(n log n) for all practical input; 32 bytes for each reference of the
// budget beside the nodes twice and the leaves once.
#pragma once

#include "libaccel/build/builder.h"
#include "libaccel/structure/bvh2.h"

namespace accel {

struct Sbvh {
  static constexpr const char* kName = "sbvh";
  using Structure = Bvh2;
  static Result<Built<Bvh2>> build(const TriangleMesh& mesh, const BuildOptions& options);
};

}  // namespace accel
