#include "libaccel/core/counter_rng.h"
#include "libaccel/rays/ray_sets.h"
#include "libaccel/rays/sampling.h"
#include "libaccel/rays/surface_hits.h"

namespace accel {

Result<RaySet> shadow_rays(const PrimaryHits& from, const LightDescription& light) {
  const Vec3d target(light.center);
  return rays_from_hits(from, 1,
                        [&](const SurfacePoint& point, std::uint64_t, std::uint32_t) { return ray_to(point.org, target); });
}

Result<RaySet> soft_shadow_rays(const PrimaryHits& from, const LightDescription& light, std::uint64_t seed,
                                std::uint32_t samples) {
  const Vec3d center(light.center), half_u(light.half_u), half_v(light.half_v);
  return rays_from_hits(from, samples, [&](const SurfacePoint& point, std::uint64_t number, std::uint32_t sample) {
    CounterRng rng(seed, number * samples + sample);
    const UnitPoint at = point_in_cell(sample, samples, rng);
    return ray_to(point.org, center + half_u * (2 * at.x - 1) + half_v * (2 * at.y - 1));
  });
}

}  // namespace accel
