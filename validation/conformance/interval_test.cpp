// What lies in front of a ray's interval does not matter, and what lies behind it is found as brute force finds it. That both
// ends belong to it is a law: laws_test.cpp.
#include <cmath>
#include <tuple>
#include <utility>

#include "libaccel/core/float_bounds.h"
#include "validation/conformance/method_test.h"
#include "validation/stress/stress_rays.h"
#include "validation/stress/stress_scenes.h"
#include "validation/unit/special_floats.h"

namespace accel::validation {
namespace {

class Interval : public MethodTest {
 protected:
  struct HitRays {
    std::vector<Ray> rays;
    std::vector<Hit> hits;
  };

  // Whether the hit's distance is more than rounding errors of the origin: rays that start on a surface meet it at any t.
  static bool is_away(const Ray& ray, const Hit& hit) {
    const int org = largest_axis(ray.org), dir = largest_axis(ray.dir);
    return hit.t * std::fabs(ray.dir[dir]) > 0x1p-12f * std::fabs(ray.org[org]);
  }

  // The rays that hit something away from their origin, with their hits.
  static HitRays rays_that_hit(const AnyAccel& accel, const TriangleMesh& mesh) {
    HitRays result;
    const std::vector<Ray> rays = stress_rays(mesh, 1500, 11);
    const std::vector<Hit> hits = closest(accel, rays);
    for (std::size_t i = 0; i < rays.size(); ++i)
      if (hits[i].valid() && is_away(rays[i], hits[i])) result.rays.push_back(rays[i]), result.hits.push_back(hits[i]);
    return result;
  }

  // The rays with intervals that depend on their hits.
  template <class Interval>
  static std::vector<Ray> with_intervals(const HitRays& from, const Interval& interval) {
    std::vector<Ray> rays = from.rays;
    for (std::size_t i = 0; i < rays.size(); ++i) std::tie(rays[i].t_min, rays[i].t_max) = interval(from.hits[i].t);
    return rays;
  }
};

TEST_P(Interval, StartsAtItsStart) {
  for (const StressScene& scene : stress_scenes()) {
    const AnyAccel accel = build(scene.mesh);
    const HitRays found = rays_that_hit(accel, scene.mesh);
    const std::vector<Ray> rays = with_intervals(found, [](float t) { return std::pair(next_up(t), kInfinity); });
    const std::vector<Hit> hits = closest(accel, rays), expected = closest(build_brute_force(scene.mesh), rays);
    expect_same(scene.name, Judge(scene.mesh), rays, hits, expected);
    for (std::size_t i = 0; i < rays.size(); ++i) EXPECT_GT(hits[i].t, found.hits[i].t) << scene.name << ", ray " << i;
  }
}

// What lies behind the origin is not seen, even when t_min is negative.
TEST_P(Interval, NeverReachesBehindTheOrigin) {
  const AnyAccel accel = build(mesh_of({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}));
  const auto hit_from = [&](float z) {
    return closest(accel, {{.org = {0.25f, 0.25f, z}, .t_min = -10, .dir = {0, 0, -1}}})[0];
  };
  EXPECT_FALSE(hit_from(-1).valid());
  EXPECT_TRUE(hit_from(0).valid());
  EXPECT_EQ(hit_from(0).t, 0.0f);
  EXPECT_TRUE(hit_from(1).valid());
}

}  // namespace

ACCEL_FOR_EVERY_METHOD(Interval);

}  // namespace accel::validation
