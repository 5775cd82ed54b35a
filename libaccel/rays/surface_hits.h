// The primary hits that secondary rays start from, checked and numbered.
#pragma once

#include "libaccel/rays/fill.h"
#include "libaccel/rays/offset_origin.h"
#include "libaccel/rays/ray_sets.h"

namespace accel {

// The numbers of the primary rays that hit something, ascending. Errors: as ray_sets.h says; per_hit is the number of rays
// wanted for each, so that the size of the set can be checked.
Result<Buffer<std::uint32_t>> rays_that_hit(const PrimaryHits& from, std::uint32_t per_hit);

// make(surface point, number of the primary ray, which of its secondary rays) -> Ray, for per_hit rays from every hit. Rays are
// numbered by rows of pixels, whatever the order in which they come.
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
    const std::uint64_t spp = from.primary.spp, number = has_pixels ? from.primary.pixel[source] * spp + source % spp : source;
    return make(point, number, static_cast<std::uint32_t>(i % per_hit));
  });
  return set;
}

// The ray from an origin to a point; its interval ends there.
Ray ray_to(Vec3 org, Vec3d target);

}  // namespace accel
