// A scene as it comes from a file or a generator: a mesh or instances of meshes, and the views and light that its author chose.
#pragma once

#include <optional>
#include <vector>

#include "libaccel/core/camera_description.h"
#include "libaccel/core/light_description.h"
#include "libaccel/geometry/triangle_source.h"

namespace accel {

struct SceneData {
  TriangleMesh mesh;                       // of a scene of instances: empty, or what one_mesh() says
  std::vector<CameraDescription> cameras;  // the first is the default; empty: see default_camera() in rays/camera.h
  std::optional<LightDescription> light;   // none: see default_light() in rays/default_light.h
  std::optional<InstancedMeshes> instances;

  // The triangles of either, by prim_id.
  TriangleSource triangles() const { return instances ? TriangleSource(*instances) : TriangleSource(mesh); }
  // All triangles as one mesh: that of the scene, or the instances' (see InstancedMeshes::flattened()).
  Result<TriangleMesh> one_mesh() const { return instances ? instances->flattened() : Result<TriangleMesh>(mesh); }
  bool is_better_apart() const { return instances && instances->is_better_apart(); }
  std::size_t size_bytes() const { return instances ? instances->size_bytes() : mesh.size_bytes(); }
};

}  // namespace accel
