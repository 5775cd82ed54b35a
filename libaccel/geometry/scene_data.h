// A scene as it comes from a file or a generator: a mesh or instances of meshes, and the views and light that its author chose.
#pragma once

#include <optional>
#include <vector>

#include "libaccel/core/camera_description.h"
#include "libaccel/core/light_description.h"
#include "libaccel/geometry/triangle_source.h"

namespace accel {

// Whether instances that place so many triangles, of meshes that have so many, are better kept apart than made one mesh: where
// that is large, and mostly copies. One mesh is 1.1 to 1.6 times as fast to trace, but takes as much more memory as there are
// copies, and as much longer to build: two seconds for a million triangles.
inline constexpr std::uint64_t kLargeMesh = 1 << 20, kMostlyCopies = 4;
constexpr bool are_better_apart(std::uint64_t placed, std::uint64_t of_meshes) {
  return placed >= kLargeMesh && placed > kMostlyCopies * of_meshes;
}

struct SceneData {
  TriangleMesh mesh;                       // of a scene of instances: empty, or what one_mesh() says
  std::vector<CameraDescription> cameras;  // the first is the default; empty: see default_camera() in rays/camera.h
  std::optional<LightDescription> light;   // none: see default_light() in rays/default_light.h
  std::optional<InstancedMeshes> instances;

  // The triangles of either, by prim_id.
  TriangleSource triangles() const { return instances ? TriangleSource(*instances) : TriangleSource(mesh); }
  // All triangles as one mesh: that of the scene, or the instances' (see InstancedMeshes::flattened()).
  Result<TriangleMesh> one_mesh() const { return instances ? instances->flattened() : Result<TriangleMesh>(mesh); }
  // Of scenes of instances: see above.
  bool is_better_apart() const {
    std::uint64_t of_meshes = 0;
    if (instances)
      for (const TriangleMesh& m : instances->meshes()) of_meshes += m.size();
    return instances && are_better_apart(instances->size(), of_meshes);
  }
  std::size_t size_bytes() const { return instances ? instances->size_bytes() : mesh.size_bytes(); }
};

}  // namespace accel
