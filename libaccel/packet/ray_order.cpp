#include "libaccel/packet/ray_order.h"

#include <tbb/task_arena.h>

#include <chrono>
#include <cmath>
#include <new>
#include <utility>
#include <vector>

#include "libaccel/core/hit.h"
#include "libaccel/core/out_of_memory.h"
#include "libaccel/core/suggest.h"
#include "libaccel/core/threads.h"
#include "libaccel/packet/cpu_primitives.h"
#include "libaccel/packet/csd_sort.h"
#include "libaccel/packet/ray_hash.h"

namespace accel {
namespace {

// 10 bits of each of five coordinates, in turns: three of the origin, and two of the direction on the octahedral map of Cigolle
// et al. 2014, which makes a square of the sphere.
std::uint64_t origin_direction_code(const Ray& ray, const Aabb& bounds) {
  const float sum = std::fabs(ray.dir.x) + std::fabs(ray.dir.y) + std::fabs(ray.dir.z);
  float u = ray.dir.x / sum, v = ray.dir.y / sum;
  if (ray.dir.z < 0) {
    const float folded = (1 - std::fabs(v)) * (u < 0 ? -1.0f : 1.0f);
    v = (1 - std::fabs(u)) * (v < 0 ? -1.0f : 1.0f), u = folded;
  }
  const std::uint64_t direction = morton_2d(quantize(u, -1, 1, 10), quantize(v, -1, 1, 10)),
                      origin = morton_30(ray.org, bounds);
  std::uint64_t code = 0;
  for (int level = 9; level >= 0; --level) code = code << 5 | (origin >> 3 * level & 7u) << 2 | (direction >> 2 * level & 3u);
  return code;
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

template <class Hash>
RayOrder order_by(std::span<const Ray> rays, const Hash& hash, bool compresses) {
  RayOrder order;
  auto start = std::chrono::steady_clock::now();
  Buffer<std::uint64_t> values(rays.size());
  CpuPrimitives::for_each(rays.size(), [&](std::size_t i) { values[i] = hash(rays[i]); });
  order.hash_seconds = seconds_since(start);

  start = std::chrono::steady_clock::now();
  if (compresses) {
    auto sorted = csd_sort<CpuPrimitives>(std::as_const(values).data(), values.size());
    order.ids = std::move(sorted.ids), order.chunks = sorted.chunks;
  } else {
    order.ids = plain_sort<CpuPrimitives>(values.data(), values.size()), order.chunks = rays.size();
  }
  order.sort_seconds = seconds_since(start);
  return order;
}

}  // namespace

const char* name_of(RaySort sort) { return sort == RaySort::ray_hash ? "ray-hash" : "morton"; }

Result<RaySort> parse_ray_sort(std::string_view name) {
  std::vector<std::string_view> known;
  for (const RaySort sort : kRaySorts) {
    known.emplace_back(name_of(sort));
    if (known.back() == name) return sort;
  }
  return unknown_name("sort", name, known);
}

Result<RayOrder> order_rays(std::span<const Ray> rays, const Aabb& bounds, const RayOrderOptions& options) try {
  tbb::task_arena arena(arena_size(options.threads));
  return arena.execute([&] {
    if (options.sort == RaySort::morton)
      return order_by(
          rays, [&](const Ray& ray) { return origin_direction_code(ray, bounds); }, false);
    return order_by(rays, RayHash<std::uint64_t>::make(bounds, options.cell_fraction), true);
  });
} catch (const std::bad_alloc&) {
  return out_of_memory("sorting rays");
}

void gather_rays(std::span<const Ray> from, std::span<const std::uint32_t> ids, std::span<Ray> to, int threads) {
  ACCEL_ASSERT(from.size() == ids.size() && to.size() == ids.size());
  tbb::task_arena arena(arena_size(threads));
  arena.execute([&] { CpuPrimitives::for_each(ids.size(), [&](std::size_t i) { to[i] = from[ids[i]]; }); });
}

template <class T>
void scatter(std::span<const T> from, std::span<const std::uint32_t> ids, std::span<T> to, int threads) {
  ACCEL_ASSERT(from.size() == ids.size() && to.size() == ids.size());
  tbb::task_arena arena(arena_size(threads));
  arena.execute([&] { CpuPrimitives::for_each(ids.size(), [&](std::size_t i) { to[ids[i]] = from[i]; }); });
}
template void scatter(std::span<const Hit>, std::span<const std::uint32_t>, std::span<Hit>, int);
template void scatter(std::span<const std::uint8_t>, std::span<const std::uint32_t>, std::span<std::uint8_t>, int);

}  // namespace accel
