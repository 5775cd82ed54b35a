// The primary hits that secondary rays start from, checked and numbered.
#pragma once

#include "libaccel/rays/fill.h"
#include "libaccel/rays/offset_origin.h"
#include "libaccel/rays/ray_sets.h"

namespace accel {

// The numbers of the primary rays that hit something, ascending. Errors: as ray_sets.h says; per_hit is the number of rays
// wanted for each, so that the size of the set can be checked.
Result<Buffer<std::uint32_t>> rays_that_hit(const PrimaryHits& from, std::uint32_t per_hit);

// A number that no other ray of the set has, and that does not depend on the order of pixels: which pixel, and which of its
// rays, which are side by side.
inline std::uint64_t ray_number(const RaySet& set, std::uint64_t ray) {
  if (set.pixel.empty()) return ray;
  std::uint64_t before = 0;
  while (before < ray && set.pixel[ray - before - 1] == set.pixel[ray]) ++before;
  return before << 32 | set.pixel[ray];
}

// make(surface point, ray_number() of the primary ray, which of its secondary rays) -> Ray, for per_hit rays from every hit.
template <class Make>
Result<RaySet> rays_from_hits(const PrimaryHits& from, std::uint32_t per_hit, const Make& make) {
  const auto sources = rays_that_hit(from, per_hit);
  if (!sources.ok()) return sources.error();
  const bool has_pixels = !from.primary.pixel.empty();
  const std::size_t count = sources->size() * per_hit;
  RaySet set{Buffer<Ray>(count), Buffer<std::uint32_t>(has_pixels ? count : 0)};
  fill(set.pixel.span(), [&](std::size_t i) { return from.primary.pixel[(*sources)[i / per_hit]]; });
  fill(set.rays.span(), [&](std::size_t i) {
    const std::uint32_t source = (*sources)[i / per_hit];
    const Hit& hit = from.hits[source];
    const SurfacePoint point = offset_origin(from.triangles.triangle(hit.prim_id), hit, from.primary.rays[source].dir,
                                             from.triangles.position_error(hit.prim_id));
    return make(point, ray_number(from.primary, source), static_cast<std::uint32_t>(i % per_hit));
  });
  return set;
}

// The ray from an origin to a point; its interval ends there.
Ray ray_to(Vec3 org, Vec3d target);

}  // namespace accel
