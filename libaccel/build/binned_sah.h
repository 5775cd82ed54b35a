// Builds a Bvh2 top down with the surface-area heuristic over bins.
//
// Wald 2007, "On fast Construction of SAH-based Bounding Volume Hierarchies". Deviations: bins along all three axes, not only
// the widest; fewer bins for small sets; the deterministic parallel partition of partition.h in place of per-thread queues.
//
// Invariants: every triangle is in exactly one leaf; depth <= options.max_depth. Sets that the heuristic cannot split are
// halved at the median, so that a million identical triangles make a balanced tree. O(n log n) for all practical input; 32
// bytes a triangle beside the nodes twice and the leaves once.
#pragma once

#include "libaccel/build/builder.h"
#include "libaccel/structure/bvh2.h"

namespace accel {

struct BinnedSah {
  static constexpr const char* kName = "bvh";
  using Structure = Bvh2;
  static Result<Built<Bvh2>> build(const TriangleMesh& mesh, const BuildOptions& options);
};

}  // namespace accel
