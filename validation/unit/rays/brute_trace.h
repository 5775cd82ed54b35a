// Closest hits by brute force, for tests on small meshes.
#pragma once

#include <vector>

#include "libaccel/build/triangle_list.h"
#include "libaccel/exec/cpu.h"
#include "libaccel/geometry/watertight.h"
#include "libaccel/trace/brute_force.h"

namespace accel {

inline std::vector<Hit> brute_trace(const TriangleMesh& mesh, std::span<const Ray> rays) {
  const auto built = ListBuilder::build(mesh, {});
  std::vector<Hit> hits(rays.size());
  if (built.ok()) trace_closest<BruteForce<Watertight, Query::closest>>(built->structure.view(), rays, hits, 0);
  return hits;
}

}  // namespace accel
