// Rays that hurt by kind: what a case of the catalogue traces (catalogue.h).
#pragma once

#include <cstdint>
#include <vector>

#include "libaccel/core/ray.h"
#include "libaccel/geometry/triangle_mesh.h"

namespace accel::validation {

enum class RayKind : std::uint8_t {
  mixed,                // stress_rays() and cell_stress_rays(), half of each
  at_vertices,          // org + dir is a vertex, exactly where floats permit it
  beside_vertices,      // one float beside it
  at_edges,             // org + dir is one to seven eighths along an edge
  beside_edges,         // one float beside that
  in_split_planes,      // in planes where trees split: through vertices, ends of boxes and middles; zeros of both signs
  along_boxes,          // in the faces and along the edges of boxes, of the scene's and of triangles'
  axis_parallel,        // two zeros of either sign
  from_surfaces,        // the origin is rounded to a surface or an edge
  from_vertices,        // the origin is a vertex
  from_planes,          // one coordinate of the origin is a vertex's
  hit_at_t_min,         // t_min is 1, where the target is, or one float beside it
  hit_at_t_max,         // t_max likewise
  all_intervals,        // t_min from -inf, t_max up to inf, both zeros
  empty_intervals,      // t_max is below t_min, by a float or by more, or below 0
  any_length,           // the largest component from 2^-100 (1e-30) to 2^60 (1e18)
  denormal_parts,       // some components are denormal
  in_triangles_planes,  // in the plane of a triangle, along an edge or across
  far_away,             // a hundred and a thousand times the scene's size away
  farther_away,         // ten thousand and a million times
  not_rays,             // NaN, infinite, out of range, zero directions, empty intervals
};

// About `count` rays of a kind for a mesh. Seeded; a ray depends on its number alone. All but empty_intervals and not_rays are
// traceable.
std::vector<Ray> rays_of_kind(RayKind kind, const TriangleMesh& mesh, std::size_t count, std::uint64_t seed);

}  // namespace accel::validation
