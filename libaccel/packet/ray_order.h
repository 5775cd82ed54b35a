// Puts the rays of a batch into an order in which neighbours are coherent, for any method to trace them faster.
//
// Closest hits and occlusion do not depend on the order of rays, so hits that are scattered back are those of the batch as it
// came. Whether sorting pays depends on rays and structure: it costs some nanoseconds a ray, tells how many, and gains where
// rays that follow each other go far apart and the structure does not fit the caches.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "libaccel/core/aabb.h"
#include "libaccel/core/buffer.h"
#include "libaccel/core/ray.h"
#include "libaccel/core/result.h"

namespace accel {

enum class RaySort : std::uint8_t {
  ray_hash,  // Garanzha and Loop 2010: packet/ray_hash.h, by packet/csd_sort.h
  morton     // a Z-curve through origins and directions in turns, as Moon et al. 2010 and others do; sorted ray by ray
};
inline constexpr RaySort kRaySorts[] = {RaySort::ray_hash, RaySort::morton};
const char* name_of(RaySort sort);  // "ray-hash"
Result<RaySort> parse_ray_sort(std::string_view name);

struct RayOrderOptions {
  RaySort sort = RaySort::ray_hash;
  float cell_fraction = 0.004f;  // ray_hash: cells of the grid, as a share of the diagonal of `bounds`; [GL10] section 5.1
  int threads = 0;               // 0: as many as the machine has
};

struct RayOrder {
  Buffer<std::uint32_t> ids;  // ids[i]: the ray that comes i-th
  std::size_t chunks = 0;     // ray_hash: runs of equal values in the batch as it came; morton: rays
  double hash_seconds = 0;    // to compute the values
  double sort_seconds = 0;    // to sort them
};

// Of fewer than 2^32 rays. `bounds` are the scene's. Rays that nothing can trace have their place, too. The same for any number
// of threads; 64-bit values. Fails where memory does not suffice.
Result<RayOrder> order_rays(std::span<const Ray> rays, const Aabb& bounds, const RayOrderOptions& options = {});

// to[i] = from[ids[i]], and to[ids[i]] = from[i]; both ends have the order's size.
void gather_rays(std::span<const Ray> from, std::span<const std::uint32_t> ids, std::span<Ray> to, int threads = 0);
template <class T>
void scatter(std::span<const T> from, std::span<const std::uint32_t> ids, std::span<T> to, int threads = 0);

}  // namespace accel
