#include "validation/stress/ray_targets.h"

#include "libaccel/core/float_bounds.h"
#include "validation/stress/hostile_floats.h"

namespace accel::validation {

RayTargets ray_targets(const TriangleMesh& mesh) {
  RayTargets targets;
  for (std::size_t i = 0; i < mesh.size(); ++i) {
    const Triangle t = mesh.triangle(i);
    if (in_range(t.v0) && in_range(t.v1) && in_range(t.v2)) targets.triangles.push_back(t);
  }
  if (targets.triangles.empty()) targets.triangles.push_back({{0, 0, 0}, {1, 0, 0}, {0, 1, 1}});
  for (const Triangle& t : targets.triangles) targets.bounds.extend(t.bounds());
  const Vec3 extent = targets.bounds.extent();
  const float largest = extent[largest_axis(extent)];
  targets.size = largest > 0 ? largest : 1.0f;
  return targets;
}

const Triangle& TargetPicker::triangle() {
  return targets_.triangles[rng_.next_below(static_cast<std::uint32_t>(targets_.triangles.size()))];
}

Vec3 TargetPicker::vertex() { return (&triangle().v0)[rng_.next_below(3)]; }

Vec3 TargetPicker::on_edge() {
  const Triangle& t = triangle();
  const std::uint32_t first = rng_.next_below(3);
  const Vec3 a = (&t.v0)[first], b = (&t.v0)[(first + 1) % 3];
  const float s = static_cast<float>(1 + rng_.next_below(7)) * 0.125f;
  return a * (1.0f - s) + b * s;
}

Vec3 TargetPicker::inside() {
  const Triangle& t = triangle();
  float u = rng_.next_float(), v = rng_.next_float();
  if (u + v > 1.0f) u = 1.0f - u, v = 1.0f - v;
  return t.v0 * (1.0f - u - v) + t.v1 * u + t.v2 * v;
}

Vec3 TargetPicker::around() {
  const float margin = 0.1f * targets_.size;
  const Vec3 extent = targets_.bounds.extent() + Vec3{margin, margin, margin};
  const Vec3 offset = random_in_cube(rng_, 1);
  return targets_.bounds.center() + extent * offset;
}

Vec3 TargetPicker::far_away() {
  const Vec3 extent = targets_.bounds.extent() + Vec3{targets_.size, targets_.size, targets_.size};
  return targets_.bounds.center() + extent * random_in_cube(rng_, 100);
}

Vec3 TargetPicker::beside(Vec3 p) {
  for (int a = 0; a < 3; ++a) {
    const std::uint32_t side = rng_.next_below(3);
    if (side != 0) p[a] = side == 1 ? next_up(p[a]) : next_down(p[a]);
  }
  return p;
}

Ray TargetPicker::axis_parallel(Vec3 point) {
  const int along = axis();
  Ray ray{.org = point, .dir = {zero(), zero(), zero()}};
  ray.dir[along] = sign();
  if (rng_.next_below(4) != 0) ray.org[along] -= ray.dir[along] * (2.0f * targets_.bounds.extent()[along] + targets_.size);
  return ray;
}

}  // namespace accel::validation
