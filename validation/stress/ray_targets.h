// What rays that hurt are aimed at, and where they start: vertices, edges and surfaces of a mesh, the space around it, and
// far away.
#pragma once

#include <cstdint>
#include <vector>

#include "libaccel/core/aabb.h"
#include "libaccel/core/counter_rng.h"
#include "libaccel/core/ray.h"
#include "libaccel/geometry/triangle_mesh.h"

namespace accel::validation {

// The usable triangles of a mesh, or a triangle of the unit cube where there are none.
struct RayTargets {
  std::vector<Triangle> triangles;
  Aabb bounds;
  float size;  // the largest extent; 1 where it is 0
};

RayTargets ray_targets(const TriangleMesh& mesh);

// Draws points for one ray. All that a ray gets depends on the seed and its number.
class TargetPicker {
 public:
  TargetPicker(const RayTargets& targets, std::uint64_t seed, std::uint64_t element) : targets_(targets), rng_(seed, element) {}

  CounterRng& rng() { return rng_; }
  const Aabb& bounds() const { return targets_.bounds; }
  float size() const { return targets_.size; }

  const Triangle& triangle();
  Vec3 vertex();
  Vec3 on_edge();       // one to seven eighths along it
  Vec3 inside();        // of a triangle
  Vec3 around();        // near the box of the mesh
  Vec3 far_away();      // a hundred times its size
  Vec3 beside(Vec3 p);  // some of its coordinates one float off

  int axis() { return static_cast<int>(rng_.next_below(3)); }
  float zero() { return (rng_.next_u64() & 1) != 0 ? 0.0f : -0.0f; }
  float sign() { return (rng_.next_u64() & 1) != 0 ? 1.0f : -1.0f; }

  // Through a point, along an axis, from outside of the scene or from the point itself. Zeros of both signs.
  Ray axis_parallel(Vec3 point);

 private:
  const RayTargets& targets_;
  CounterRng rng_;
};

}  // namespace accel::validation
