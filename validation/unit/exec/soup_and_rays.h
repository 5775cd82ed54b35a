// A triangle soup with its structures and random rays, for tests of executors.
#pragma once

#include <string>
#include <vector>

#include "libaccel/build/binned_sah.h"
#include "libaccel/build/triangle_list.h"
#include "libaccel/rays/ray_sets.h"
#include "scenes/procedural.h"

namespace accel::test {

// Hits nothing, by definition (core/ray.h).
inline constexpr Ray kDeadRay{.org = {}, .dir = {0, 0, 0}};

struct SoupAndRays {
  TriangleMesh mesh;
  Bvh2 bvh;
  TriangleList list;
  std::vector<Ray> rays;

  SoupAndRays(std::uint64_t triangles, std::uint64_t count)
      : mesh(*make_builtin("soup:" + std::to_string(triangles))->one_mesh()),
        bvh(BinnedSah::build(mesh, {})->structure),
        list(ListBuilder::build(mesh, {})->structure) {
    const RaySet set = *random_rays(bvh.bounds, count);
    rays.assign(set.rays.begin(), set.rays.end());
  }
};

}  // namespace accel::test
