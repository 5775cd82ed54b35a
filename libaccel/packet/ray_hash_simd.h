// Hash values (packet/ray_hash.h) of many rays, in SIMD lanes: the same values. Compiled for every target of the machine's
// family, by Highway; the best that the machine has runs.
#pragma once

#include <cstdint>

#include "libaccel/packet/ray_hash.h"

namespace accel {

using FineRayHash = RayHash<std::uint64_t, kFineDirectionBits>;

// values[i] of rays[ids[i]]; any ray.
void hash_rays_simd(const FineRayHash& hash, const Ray* rays, const std::uint32_t* ids, std::size_t count,
                    std::uint64_t* values);

}  // namespace accel
