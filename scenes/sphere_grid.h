// A triangulated unit sphere of any fineness, numbered in closed form: an octahedron whose faces are cut into frequency^2
// triangles.
//
// Rings of equal latitude: ring r of 0 ... 2 f has 4 min(r, 2 f - r) vertices at equal longitudes, the poles one. The mesh is
// closed: every edge belongs to two triangles, 4 f^2 + 2 vertices, 8 f^2 triangles, no degenerate ones.
#pragma once

#include <cstdint>

#include "libaccel/core/vec3d.h"
#include "libaccel/geometry/triangle_mesh.h"

namespace accel {

class SphereGrid {
 public:
  explicit SphereGrid(std::uint32_t frequency) : f_(frequency) {}

  std::uint64_t vertices() const { return 4 * f_ * f_ + 2; }
  std::uint64_t triangles() const { return 8 * f_ * f_; }

  Vec3d vertex(std::uint32_t index) const;
  IndexTriple triangle(std::uint32_t index) const;

 private:
  // The number of vertices of a ring and the number of its first one.
  std::uint64_t ring_size(std::uint64_t ring) const;
  std::uint64_t ring_start(std::uint64_t ring) const;
  std::uint32_t at(std::uint64_t ring, std::uint64_t i) const;

  std::uint64_t f_;
};

}  // namespace accel
