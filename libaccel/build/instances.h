// Builds two levels of two-box BVHs (structure/two_level.h) over a scene made of instances.
//
// One tree a mesh by Sbvh, whether the mesh is placed once or a thousand times, and one over the instances' world boxes
// (build/top_level.h). Meshes are built one after the other, each on all threads.
#pragma once

#include "libaccel/build/builder.h"
#include "libaccel/geometry/instanced_meshes.h"
#include "libaccel/structure/two_level.h"

namespace accel {

struct InstanceBuilder {
  static constexpr const char* kName = "instances";
  using Structure = TwoLevelBvh;
  static Result<Built<TwoLevelBvh>> build(const InstancedMeshes& scene, const BuildOptions& options);
};

}  // namespace accel
