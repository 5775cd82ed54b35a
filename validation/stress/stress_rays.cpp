#include "validation/stress/stress_rays.h"

#include <cmath>
#include <limits>

#include "libaccel/core/aabb.h"
#include "validation/stress/hostile_floats.h"

namespace accel::validation {

namespace {

// What rays are aimed at: the usable triangles of a mesh, or a triangle of the unit cube where there are none.
struct Targets {
  std::vector<Triangle> triangles;
  Aabb bounds;
};

Targets targets_of(const TriangleMesh& mesh) {
  Targets targets;
  for (std::size_t i = 0; i < mesh.size(); ++i) {
    const Triangle t = mesh.triangle(i);
    if (in_range(t.v0) && in_range(t.v1) && in_range(t.v2)) targets.triangles.push_back(t);
  }
  if (targets.triangles.empty()) targets.triangles.push_back({{0, 0, 0}, {1, 0, 0}, {0, 1, 1}});
  for (const Triangle& t : targets.triangles) targets.bounds.extend(t.bounds());
  return targets;
}

class RayMaker {
 public:
  RayMaker(const Targets& targets, std::uint64_t seed, std::uint64_t element) : targets_(targets), rng_(seed, element) {}

  Ray make(std::uint64_t kind) {
    switch (kind) {
      case 0:
        return aimed(around(), vertex());
      case 1:
        return aimed(around(), on_edge());
      case 2:
        return aimed(around(), inside());
      case 3:
        return {.org = around(), .dir = random_in_cube(rng_, 1)};
      case 4:
        return {.org = inside(), .dir = random_in_cube(rng_, 1)};  // starts on a surface
      case 5:
        return {.org = vertex(), .dir = random_in_cube(rng_, 1)};
      case 6:
        return aimed(vertex(), vertex());
      case 7:
        return axis_parallel(vertex());  // along faces of boxes, and where trees split
      case 8:
        return axis_parallel(inside());
      case 9:
        return in_a_plane();
      default:
        return aimed(far_away(), inside());
    }
  }
  static constexpr std::uint64_t kKinds = 11;

  Ray make_nearly_parallel(int lowest, int highest) {
    Ray ray = axis_parallel(inside());
    for (int a = 0; a < 3; ++a)
      if (ray.dir[a] == 0.0f) ray.dir[a] = random_over_exponents(rng_, lowest, highest);
    return ray;
  }

 private:
  const Triangle& triangle() {
    return targets_.triangles[rng_.next_below(static_cast<std::uint32_t>(targets_.triangles.size()))];
  }
  Vec3 vertex() { return (&triangle().v0)[rng_.next_below(3)]; }

  Vec3 on_edge() {
    const Triangle& t = triangle();
    const std::uint32_t first = rng_.next_below(3);
    const Vec3 a = (&t.v0)[first], b = (&t.v0)[(first + 1) % 3];
    const float s = static_cast<float>(1 + rng_.next_below(7)) * 0.125f;
    return a * (1.0f - s) + b * s;
  }

  Vec3 inside() {
    const Triangle& t = triangle();
    float u = rng_.next_float(), v = rng_.next_float();
    if (u + v > 1.0f) u = 1.0f - u, v = 1.0f - v;
    return t.v0 * (1.0f - u - v) + t.v1 * u + t.v2 * v;
  }

  Vec3 around() {
    const Vec3 extent = targets_.bounds.extent() + Vec3{0.1f, 0.1f, 0.1f};
    const Vec3 offset = random_in_cube(rng_, 1);
    return targets_.bounds.center() + extent * offset;
  }
  Vec3 far_away() { return targets_.bounds.center() + (targets_.bounds.extent() + Vec3{1, 1, 1}) * random_in_cube(rng_, 100); }

  static Ray aimed(Vec3 org, Vec3 target) { return {.org = org, .dir = target - org}; }

  float zero() { return (rng_.next_u64() & 1) != 0 ? 0.0f : -0.0f; }
  float sign() { return (rng_.next_u64() & 1) != 0 ? 1.0f : -1.0f; }

  // Through a point, along an axis, from outside of the scene or from the point itself.
  Ray axis_parallel(Vec3 point) {
    const int axis = static_cast<int>(rng_.next_below(3));
    Ray ray{.org = point, .dir = {zero(), zero(), zero()}};
    ray.dir[axis] = sign();
    if (rng_.next_below(4) != 0) ray.org[axis] -= ray.dir[axis] * (2.0f * targets_.bounds.extent()[axis] + 1.0f);
    return ray;
  }

  // In a plane of constant coordinate through a vertex.
  Ray in_a_plane() {
    const int axis = static_cast<int>(rng_.next_below(3));
    Ray ray = aimed(around(), vertex());
    ray.org[axis] += ray.dir[axis], ray.dir[axis] = zero();
    ray.org[axis] = vertex()[axis];
    return ray;
  }

  const Targets& targets_;
  CounterRng rng_;
};

}  // namespace

std::vector<Ray> stress_rays(const TriangleMesh& mesh, std::size_t count, std::uint64_t seed) {
  const Targets targets = targets_of(mesh);
  std::vector<Ray> rays;
  for (std::uint64_t i = 0; i < count; ++i) {
    const Ray ray = RayMaker(targets, seed, i).make(i % RayMaker::kKinds);
    if (is_traceable(ray)) rays.push_back(ray);
  }
  return rays;
}

std::vector<Ray> nearly_parallel_rays(const TriangleMesh& mesh, int lowest, int highest, std::size_t count,
                                      std::uint64_t seed) {
  const Targets targets = targets_of(mesh);
  std::vector<Ray> rays;
  for (std::uint64_t i = 0; i < count; ++i) rays.push_back(RayMaker(targets, seed, i).make_nearly_parallel(lowest, highest));
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
