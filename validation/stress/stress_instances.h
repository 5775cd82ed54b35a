// Instanced scenes that hurt: turned, mirrored, stretched, huge, tiny, overlapping, coincident, flat and empty instances.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "libaccel/geometry/instanced_meshes.h"

namespace accel::validation {

struct InstancedScene {
  std::string name;
  InstancedMeshes scene;
};
std::vector<InstancedScene> instanced_scenes(std::uint64_t seed = 1);

// A map with a random rotation, scales along the mesh's axes and a translation.
Affine placed_at(Vec3 translation, Vec3 scale, std::uint64_t seed, std::uint64_t element);

// Rays that hurt the flattened scene (stress_rays.h), and rays that aim at its vertices.
std::vector<Ray> instance_rays(const InstancedMeshes& scene, std::size_t count, std::uint64_t seed = 1);

}  // namespace accel::validation
