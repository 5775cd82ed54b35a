// The primary hits that secondary rays start from, checked and numbered.
#pragma once

#include <new>

#include "libaccel/core/out_of_memory.h"
#include "libaccel/rays/fill.h"
#include "libaccel/rays/offset_origin.h"
#include "libaccel/rays/ray_sets.h"

namespace accel {

// A primary ray that hits something.
struct HitSource {
  std::uint32_t ray;
  std::uint32_t before;  // rays of the same pixel that come before it; they are side by side

  // A number that no other ray of the set has, and that does not depend on the order of pixels.
  std::uint64_t number(const RaySet& set) const {
    return set.pixel.empty() ? ray : std::uint64_t{before} << 32 | set.pixel[ray];
  }
};

// Those of a set, ascending. Errors: as ray_sets.h says; per_hit is the number of rays wanted for each, so that the size of the
// set can be checked.
Result<Buffer<HitSource>> rays_that_hit(const PrimaryHits& from, std::uint32_t per_hit);

// make(surface point, number of the primary ray, which of its secondary rays) -> Ray, for per_hit rays from every hit.
template <class Make>
Result<RaySet> rays_from_hits(const PrimaryHits& from, std::uint32_t per_hit, const Make& make) try {
  const auto sources = rays_that_hit(from, per_hit);
  if (!sources.ok()) return sources.error();
  const bool has_pixels = !from.primary.pixel.empty();
  const std::size_t count = sources->size() * per_hit;
  RaySet set{Buffer<Ray>(count), Buffer<std::uint32_t>(has_pixels ? count : 0)};
  for_each_index(sources->size(), [&](std::size_t s) {
    const HitSource source = (*sources)[s];
    const Hit& hit = from.hits[source.ray];
    const SurfacePoint point = offset_origin(from.triangles.triangle(hit.prim_id), hit, from.primary.rays[source.ray].dir,
                                             from.triangles.position_error(hit.prim_id));
    for (std::uint32_t k = 0; k < per_hit; ++k) {
      set.rays[s * per_hit + k] = make(point, source.number(from.primary), k);
      if (has_pixels) set.pixel[s * per_hit + k] = from.primary.pixel[source.ray];
    }
  });
  return set;
} catch (const std::bad_alloc&) {
  return out_of_memory("making secondary rays; trace fewer primary rays");
}

// The ray from an origin to a point; its interval ends there.
Ray ray_to(Vec3 org, Vec3d target);

}  // namespace accel
