// Builds two levels of eight-wide BVHs (structure/two_level_bvh8.h): those of InstanceBuilder (build/instances.h), each
// collapsed at the least cost (build/collapse_wide.h). The boxes are the same, and so is what they promise.
#pragma once

#include "libaccel/build/builder.h"
#include "libaccel/geometry/instanced_meshes.h"
#include "libaccel/structure/two_level_bvh8.h"

namespace accel {

struct WideInstances {
  static constexpr const char* kName = "bvh8-instances";
  using Structure = TwoLevelBvh8;
  static Result<Built<TwoLevelBvh8>> build(const InstancedMeshes& scene, const BuildOptions& options);
};

}  // namespace accel
