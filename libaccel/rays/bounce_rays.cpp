// Diffuse bounces and ambient occlusion: cosine-weighted directions about the facing normal, without and with an end.
#include <limits>

#include "libaccel/core/counter_rng.h"
#include "libaccel/rays/ray_sets.h"
#include "libaccel/rays/sampling.h"
#include "libaccel/rays/surface_hits.h"

namespace accel {
namespace {

Result<RaySet> bounce_rays(const PrimaryHits& from, float t_max, std::uint64_t seed) {
  return rays_from_hits(from, 1, [&](const SurfacePoint& point, std::uint64_t number, std::uint32_t) {
    CounterRng rng(seed, number);
    return Ray{.org = point.org, .dir = cosine_direction(point.normal, rng).to_float(), .t_max = t_max};
  });
}

}  // namespace

Result<RaySet> diffuse_rays(const PrimaryHits& from, std::uint64_t seed) {
  return bounce_rays(from, std::numeric_limits<float>::infinity(), seed);
}

Result<RaySet> ao_rays(const PrimaryHits& from, float max_distance, std::uint64_t seed) {
  if (!(max_distance >= 0.0f)) return Error{"ao rays: the distance is negative or not a number"};
  return bounce_rays(from, max_distance, seed);
}

float default_ao_distance(const Aabb& bounds) {
  return bounds.empty() ? 0.0f : static_cast<float>(0.1 * length(Vec3d(bounds.hi) - Vec3d(bounds.lo)));
}

}  // namespace accel
