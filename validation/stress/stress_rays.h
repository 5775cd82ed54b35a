// Rays that hurt, for a mesh: aimed at vertices and edges, along faces, starting on surfaces and on planes where trees split,
// with zero components of both signs.
#pragma once

#include <cstdint>
#include <vector>

#include "libaccel/core/ray.h"
#include "libaccel/geometry/triangle_mesh.h"

namespace accel::validation {

// Traceable rays whose interval is [0, inf], about `count` of them, equally many of each kind. Seeded. No component of a
// direction has a magnitude between 0 and 2^-60, unless the scene is that small; nearly_parallel_rays() are for those.
std::vector<Ray> stress_rays(const TriangleMesh& mesh, std::size_t count, std::uint64_t seed = 1);

// Rays along an axis whose other two components are tiny: of magnitudes from 2^lowest to 2^(highest + 1).
std::vector<Ray> nearly_parallel_rays(const TriangleMesh& mesh, int lowest, int highest, std::size_t count,
                                      std::uint64_t seed = 1);

// Rays that are not a set of points, which every method must call misses: NaN, infinities, zero directions, inverted intervals.
std::vector<Ray> invalid_rays();

}  // namespace accel::validation
