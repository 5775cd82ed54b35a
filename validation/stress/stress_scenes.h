// Small scenes that hurt builders and traversers: empty, flat, repeated, nested, far away, broken. Seeded; hundreds of
// triangles each, so that brute force over all of them is quick.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "libaccel/geometry/triangle_mesh.h"

namespace accel::validation {

struct StressScene {
  std::string name;
  TriangleMesh mesh;
};

std::vector<StressScene> stress_scenes(std::uint64_t seed = 1);

// A mesh of separate triangles: prim_id i is triangles[i].
TriangleMesh mesh_of(const std::vector<Triangle>& triangles);

// Triangles of random shape: centres in the unit cube, edges about `size` long.
std::vector<Triangle> random_triangles(std::uint32_t count, float size, std::uint64_t seed);

}  // namespace accel::validation
