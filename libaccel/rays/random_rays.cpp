#include <new>
#include <string>

#include "libaccel/core/counter_rng.h"
#include "libaccel/core/out_of_memory.h"
#include "libaccel/rays/fill.h"
#include "libaccel/rays/ray_sets.h"
#include "libaccel/rays/sampling.h"
#include "libaccel/rays/scene_box.h"

namespace accel {

Result<RaySet> random_rays(const Aabb& bounds, std::uint64_t count, std::uint64_t seed) try {
  if (count > kMaxRays) return Error{"random rays: " + std::to_string(count) + " are more than 2^32; ask for fewer"};
  const Aabb box = enlarged(bounds, 0.1f);
  RaySet set{Buffer<Ray>(count), {}};
  fill(set.rays.span(), [&](std::size_t i) {
    CounterRng rng(seed, i);
    const Vec3 org = point_in_box(box, rng);
    return Ray{.org = org, .dir = sphere_direction(rng).to_float()};
  });
  return set;
} catch (const std::bad_alloc&) {
  return out_of_memory("making random rays; ask for fewer");
}

}  // namespace accel
