// What a mesh contains, as far as builders and reports want to know: triangles that no ray can hit, and extents.
#pragma once

#include <cstdint>

#include "libaccel/geometry/triangle_mesh.h"
#include "libaccel/geometry/triangle_source.h"

namespace accel {

// Whether the vertices provably lie on one line: no ray meets such a triangle but edge-on, which by definition is a miss. The
// proof is exact arithmetic on doubles; where coordinates differ too much in magnitude for that, the answer is no. Coordinates
// are finite.
bool is_zero_area(const Triangle& triangle);

// Whether every coordinate is finite and within kMaxCoordinate.
bool is_in_range(const Triangle& triangle);

struct MeshFacts {
  std::uint64_t triangles = 0;
  std::uint64_t zero_area = 0;  // of those in range
  std::uint64_t out_of_range = 0;
  Aabb bounds;  // of the triangles that rays can hit
};

// One pass over all triangles; indices are in range. Those of instances count once for every instance.
MeshFacts mesh_facts(const TriangleSource& triangles);

}  // namespace accel
