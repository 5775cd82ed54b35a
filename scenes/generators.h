// The generators behind make_builtin(), one file each. `size` is the number of triangles wanted, at least 1.
#pragma once

#include <cstdint>

#include "libaccel/geometry/scene_data.h"

namespace accel {

SceneData make_stadium(std::uint64_t size, std::uint64_t seed);
SceneData make_cornell(std::uint64_t size, std::uint64_t seed);
SceneData make_soup(std::uint64_t size, std::uint64_t seed);
SceneData make_slivers(std::uint64_t size, std::uint64_t seed);
SceneData make_terrain(std::uint64_t size, std::uint64_t seed);
SceneData make_hairball(std::uint64_t size, std::uint64_t seed);
SceneData make_colonnade(std::uint64_t size, std::uint64_t seed);
SceneData make_spheres(std::uint64_t size, std::uint64_t seed);
SceneData make_forest(std::uint64_t size, std::uint64_t seed);
SceneData make_deep(std::uint64_t size, std::uint64_t seed);

// The number of steps a side, at least 1, for which `per_square` triangles a square of steps come closest to `budget`
// triangles.
std::uint32_t steps_for(double budget, double per_square);

}  // namespace accel
