// Triangles by prim_id, from a mesh or from instances of meshes: for code that looks at some triangles of either.
#pragma once

#include "libaccel/geometry/instanced_meshes.h"
#include "libaccel/geometry/triangle_mesh.h"

namespace accel {

// Refers to the scene, which must outlive it.
class TriangleSource {
 public:
  TriangleSource(const TriangleMesh& mesh) : mesh_(&mesh) {}
  TriangleSource(const InstancedMeshes& instances) : instances_(&instances) {}

  std::uint64_t size() const { return mesh_ != nullptr ? mesh_->size() : instances_->size(); }
  // In the world, rounded to floats.
  Triangle triangle(std::uint32_t prim_id) const {
    return mesh_ != nullptr ? mesh_->triangle(prim_id) : instances_->triangle(prim_id);
  }

  // How far from there, along any axis, a ray that starts nearby may meet it, beyond the errors of its test.
  double position_error(std::uint32_t prim_id) const { return mesh_ != nullptr ? 0 : instances_->position_error(prim_id); }

 private:
  const TriangleMesh* mesh_ = nullptr;
  const InstancedMeshes* instances_ = nullptr;
};

}  // namespace accel
