// Closed meshes: every edge belongs to two triangles, so that a ray from inside must hit, whatever the vertices are rounded to.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "libaccel/core/counter_rng.h"
#include "libaccel/core/vec3d.h"
#include "libaccel/geometry/triangle_mesh.h"

namespace accel::validation {

// Where a mesh of about unit size is put: scaled, then moved by `offset` times the scale along (1, -1/2, 3/4), in double, and
// rounded once.
struct Placement {
  double scale = 1, offset = 0;

  Vec3d operator()(Vec3d p) const { return (p + Vec3d{1, -0.5, 0.75} * offset) * scale; }
};

struct ClosedMesh {
  std::string name;
  TriangleMesh mesh;  // of extents between 1 and 4, around the origin

  // A point that is inside however vertices are rounded, as long as they move by less than a tenth of the mesh's size.
  Vec3d inside(CounterRng& rng) const;
  // A point outside, up to three times the size away.
  Vec3d outside(CounterRng& rng) const;

  double ring_radius = 0;  // inside points lie around this circle in the plane z = 0; a ball around the origin where it is 0
  double inside_radius = 0.1;
};

// A sphere, a torus, a sphere displaced by noise, one with bumps on every vertex, and a torus of slivers, each of about
// `triangles`; seeded.
std::vector<ClosedMesh> closed_meshes(std::uint64_t triangles, std::uint64_t seed);

TriangleMesh placed(const TriangleMesh& mesh, const Placement& placement);

}  // namespace accel::validation
