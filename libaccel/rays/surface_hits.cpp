#include "libaccel/rays/surface_hits.h"

#include <string>

#include "libaccel/core/float_bounds.h"

namespace accel {

Result<Buffer<HitSource>> rays_that_hit(const PrimaryHits& from, std::uint32_t per_hit) {
  const std::size_t count = from.primary.size();
  if (from.hits.size() != count)
    return Error{"secondary rays: " + std::to_string(count) + " primary rays, but " + std::to_string(from.hits.size()) +
                 " hits"};
  if (const std::size_t pixels = from.primary.pixel.size(); pixels != 0 && pixels != count)
    return Error{"secondary rays: " + std::to_string(count) + " primary rays, but pixels of " + std::to_string(pixels)};
  if (per_hit == 0) return Error{"secondary rays: 0 rays from every hit; ask for at least 1"};
  if (count > kMaxRays / per_hit)
    return Error{"secondary rays: more than 2^32 rays from " + std::to_string(count) + " primary rays; trace fewer of those"};

  const Buffer<std::uint32_t>& pixel = from.primary.pixel;
  Buffer<HitSource> sources(count);
  std::size_t used = 0;
  std::uint32_t before = 0;
  for (std::size_t i = 0; i < count; ++i) {
    before = !pixel.empty() && i > 0 && pixel[i - 1] == pixel[i] ? before + 1 : 0;
    const Hit& hit = from.hits[i];
    if (!hit.valid()) continue;
    if (hit.prim_id >= from.triangles.size())
      return Error{"secondary rays: hit " + std::to_string(i) + " names triangle " + std::to_string(hit.prim_id) +
                   ", but the scene has " + std::to_string(from.triangles.size()) + "; are the hits of another scene?"};
    sources[used++] = {static_cast<std::uint32_t>(i), before};
  }
  sources.truncate(used);
  return sources;
}

Ray ray_to(Vec3 org, Vec3d target) {
  const Vec3d way = target - Vec3d(org);
  const double distance = length(way);
  // An origin on the light itself has nothing in between: any direction will do, for an interval of no length.
  if (!(distance > 0)) return {.org = org, .dir = {0, 1, 0}, .t_max = 0.0f};
  return {.org = org, .dir = (way * (1 / distance)).to_float(), .t_max = round_down(distance)};
}

}  // namespace accel
