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

// The scene's instances in place of those that the structure has, for frames in which instances move, come and go: the trees
// over meshes stay, that over instances is built anew, over boxes that may be less tight than a build's. The scene's meshes are
// those that were built, which nobody has changed; an error where there are more or fewer of them, or of triangles in one.
// `bvh` stays as it is: blocks of triangles are shared, nodes are copied. O(n log n) for n instances, and O(nodes); the same
// bytes for any number of threads. The report is of this alone, without triangles.
Result<Built<TwoLevelBvh8>> move_instances(const TwoLevelBvh8& bvh, const InstancedMeshes& scene, const BuildOptions& options);

}  // namespace accel
