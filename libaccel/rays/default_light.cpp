#include "libaccel/rays/default_light.h"

#include <algorithm>

#include "libaccel/core/ray.h"
#include "libaccel/core/vec3d.h"

namespace accel {
namespace {

bool inside(Vec3 p, const Aabb& box) { return box.contains(Aabb{p, p}); }

}  // namespace

LightDescription default_light(const Aabb& bounds, const CameraDescription& camera) {
  const bool usable = !bounds.empty() && in_range(bounds.lo) && in_range(bounds.hi);
  const Aabb box = usable ? bounds : Aabb{{0, 0, 0}, {1, 1, 1}};
  const int up = largest_axis(camera.up), u = (up + 1) % 3, v = (up + 2) % 3;
  const bool downwards = camera.up[up] < 0;
  const Vec3 extent = box.extent();
  const double diagonal = length(Vec3d(box.hi) - Vec3d(box.lo));

  LightDescription light;
  light.center = box.center();
  const double ceiling = downwards ? box.lo[up] : box.hi[up], to_ceiling = ceiling - light.center[up];
  const double outwards = downwards ? -0.5 : 0.5;
  light.center[up] =
      static_cast<float>(inside(camera.eye, box) ? light.center[up] + 0.8 * to_ceiling : ceiling + outwards * diagonal);
  const double side = std::max(0.25 * std::min(extent[u], extent[v]), 0.1 * diagonal);
  light.half_u[u] = light.half_v[v] = static_cast<float>(side / 2);
  return light;
}

}  // namespace accel
