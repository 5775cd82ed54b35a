// Scenes and rays that hurt structures of cells, kd-trees and grids: everything lies in planes, and rays run in planes.
#pragma once

#include <cstdint>
#include <vector>

#include "libaccel/core/ray.h"
#include "validation/stress/stress_scenes.h"

namespace accel::validation {

// Grids of axis-aligned quads, flat scenes, a thousand planes at one place or one float apart, and scenes at huge and tiny
// scales. Some hundred triangles each, a few thousand at most.
std::vector<StressScene> cell_stress_scenes(std::uint64_t seed = 1);

// Rays for a mesh whose vertices lie where cells end: parallel to one axis or two, in planes of vertices and one float beside
// them, with zeros of both signs; from planes and from vertices; along the edges and faces of the scene's box and of the box
// that padding makes of it; with denormal components. Their interval is [0, inf].
std::vector<Ray> cell_stress_rays(const TriangleMesh& mesh, std::size_t count, std::uint64_t seed = 1);

// Rays from `extents` times the size of the scene's box away, aimed at triangles.
std::vector<Ray> far_rays(const TriangleMesh& mesh, float extents, std::size_t count, std::uint64_t seed = 1);

}  // namespace accel::validation
