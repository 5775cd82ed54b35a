#include "validation/stress/stress_rays.h"

#include <cmath>
#include <limits>

#include "validation/stress/hostile_floats.h"
#include "validation/stress/ray_targets.h"

namespace accel::validation {

namespace {

Ray aimed(Vec3 org, Vec3 target) { return {.org = org, .dir = target - org}; }

// In a plane of constant coordinate through a vertex.
Ray in_a_plane(TargetPicker& pick) {
  const int axis = pick.axis();
  Ray ray = aimed(pick.around(), pick.vertex());
  ray.org[axis] += ray.dir[axis], ray.dir[axis] = pick.zero();
  ray.org[axis] = pick.vertex()[axis];
  return ray;
}

constexpr std::uint64_t kKinds = 11;

Ray make(TargetPicker& pick, std::uint64_t kind) {
  switch (kind) {
    case 0:
      return aimed(pick.around(), pick.vertex());
    case 1:
      return aimed(pick.around(), pick.on_edge());
    case 2:
      return aimed(pick.around(), pick.inside());
    case 3:
      return {.org = pick.around(), .dir = random_in_cube(pick.rng(), 1)};
    case 4:
      return {.org = pick.inside(), .dir = random_in_cube(pick.rng(), 1)};  // starts on a surface
    case 5:
      return {.org = pick.vertex(), .dir = random_in_cube(pick.rng(), 1)};
    case 6:
      return aimed(pick.vertex(), pick.vertex());
    case 7:
      return pick.axis_parallel(pick.vertex());  // along faces of boxes, and where trees split
    case 8:
      return pick.axis_parallel(pick.inside());
    case 9:
      return in_a_plane(pick);
    default:
      return aimed(pick.far_away(), pick.inside());
  }
}

}  // namespace

std::vector<Ray> stress_rays(const TriangleMesh& mesh, std::size_t count, std::uint64_t seed) {
  const RayTargets targets = ray_targets(mesh);
  std::vector<Ray> rays;
  for (std::uint64_t i = 0; i < count; ++i) {
    TargetPicker pick(targets, seed, i);
    const Ray ray = make(pick, i % kKinds);
    if (is_traceable(ray)) rays.push_back(ray);
  }
  return rays;
}

std::vector<Ray> nearly_parallel_rays(const TriangleMesh& mesh, int lowest, int highest, std::size_t count,
                                      std::uint64_t seed) {
  const RayTargets targets = ray_targets(mesh);
  std::vector<Ray> rays;
  for (std::uint64_t i = 0; i < count; ++i) {
    TargetPicker pick(targets, seed, i);
    Ray ray = pick.axis_parallel(pick.inside());
    for (int a = 0; a < 3; ++a)
      if (ray.dir[a] == 0.0f) ray.dir[a] = random_over_exponents(pick.rng(), lowest, highest);
    rays.push_back(ray);
  }
  return rays;
}

std::vector<Ray> invalid_rays() {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const float nan = std::nanf("");
  const Ray good{.org = {0.3f, 0.2f, 5}, .dir = {0, 0, -1}};
  std::vector<Ray> rays;
  for (const float bad : {nan, kInfinity, -kInfinity, 2e18f, -2e18f})
    for (int axis = 0; axis < 3; ++axis) {
      rays.insert(rays.end(), 2, good);
      rays.back().dir[axis] = bad;
      rays[rays.size() - 2].org[axis] = bad;
    }
  rays.push_back({.org = good.org, .dir = {0, -0.0f, 0}});
  const std::pair<float, float> intervals[] = {{nan, kInfinity}, {0, nan}, {nan, nan}, {10, 1},
                                               {kInfinity, 0},   {-2, -1}, {0, -1},    {0, -kInfinity}};
  for (const auto& [t_min, t_max] : intervals)
    rays.push_back({.org = good.org, .t_min = t_min, .dir = good.dir, .t_max = t_max});
  return rays;
}

}  // namespace accel::validation
