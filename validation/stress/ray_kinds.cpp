#include "validation/stress/ray_kinds.h"

#include <cmath>
#include <iterator>
#include <limits>
#include <tuple>
#include <utility>

#include "libaccel/core/float_bounds.h"
#include "libaccel/rays/aim.h"
#include "validation/stress/hostile_floats.h"
#include "validation/stress/ray_targets.h"
#include "validation/stress/stress_cells.h"
#include "validation/stress/stress_rays.h"

namespace accel::validation {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kLargest = std::numeric_limits<float>::max();

Ray aim_from_around(TargetPicker& pick, Vec3 target) { return aim(pick.around(), target); }

// In the plane where coordinate `axis` is `plane`.
Ray put_into_plane(TargetPicker& pick, Ray ray, int axis, float plane) {
  ray.org[axis] = plane, ray.dir[axis] = pick.zero();
  return ray;
}

Ray in_split_plane(TargetPicker& pick) {
  const int axis = pick.axis();
  const Vec3 target = pick.inside();
  const Aabb box = pick.triangle().bounds();
  const float planes[] = {pick.vertex()[axis], box.lo[axis], box.hi[axis], box.center()[axis], pick.bounds().center()[axis]};
  return put_into_plane(pick, aim_from_around(pick, target), axis, planes[pick.rng().next_below(std::size(planes))]);
}

// On a face of a box, or on an edge of it where the direction is along an axis; from a corner or from outside.
Ray along_box(TargetPicker& pick) {
  const Aabb box = pick.rng().next_below(2) != 0 ? pick.bounds() : pick.triangle().bounds();
  const int axis = pick.axis(), other = (axis + 1) % 3;
  Ray ray{.dir = {pick.zero(), pick.zero(), pick.zero()}};
  for (int a = 0; a < 3; ++a) ray.org[a] = pick.rng().next_below(2) != 0 ? box.lo[a] : box.hi[a];
  ray.dir[axis] = ray.org[axis] == box.lo[axis] ? 1.0f : -1.0f;
  if (pick.rng().next_below(2) != 0) ray.dir[other] = pick.sign() * pick.rng().next_float();
  if (pick.rng().next_below(2) != 0) ray.org = ray.org - ray.dir * (2.0f * pick.size());
  return ray;
}

Ray from_plane(TargetPicker& pick) {
  Ray ray = aim_from_around(pick, pick.inside());
  const int axis = pick.axis();
  ray.org[axis] = pick.vertex()[axis];
  if (pick.rng().next_below(3) == 0) ray.dir[axis] = pick.zero();
  return ray;
}

Vec3 any_target(TargetPicker& pick) {
  const std::uint32_t which = pick.rng().next_below(3);
  return which == 0 ? pick.vertex() : which == 1 ? pick.on_edge() : pick.inside();
}

// 1 or a float beside it.
float about_one(TargetPicker& pick) {
  const float values[] = {1.0f, next_down(1.0f), next_up(1.0f)};
  return values[pick.rng().next_below(3)];
}

Ray with_interval(TargetPicker& pick) {
  const float begins[] = {
      0.0f, -0.0f, -kInfinity, -kLargest, std::numeric_limits<float>::denorm_min(), pick.rng().next_float()};
  const float ends[] = {kInfinity, kLargest, 1e18f, 1.0f + pick.rng().next_float()};
  Ray ray = aim_from_around(pick, any_target(pick));
  ray.t_min = begins[pick.rng().next_below(std::size(begins))], ray.t_max = ends[pick.rng().next_below(std::size(ends))];
  return ray;
}

Ray with_empty_interval(TargetPicker& pick) {
  const float t = pick.rng().next_float(0.5f, 1.5f);
  const std::pair<float, float> intervals[] = {{t, next_down(t)}, {1, 0},  {kInfinity, 0},          {kInfinity, kLargest},
                                               {-2, -1},          {0, -t}, {-kInfinity, -0x1p-149f}};
  Ray ray = aim_from_around(pick, any_target(pick));
  std::tie(ray.t_min, ray.t_max) = intervals[pick.rng().next_below(std::size(intervals))];
  return ray;
}

// The direction scaled by a power of two, which changes no bit of it but its exponent: its largest component becomes one of
// 2^-100 to 2^60.
Ray with_any_length(TargetPicker& pick) {
  Ray ray = aim_from_around(pick, any_target(pick));
  const float largest = std::fabs(ray.dir[largest_axis(ray.dir)]);
  if (largest == 0) return ray;
  const int exponent = static_cast<int>(pick.rng().next_below(161)) - 100 - std::ilogb(largest);
  for (int a = 0; a < 3; ++a) ray.dir[a] = std::ldexp(ray.dir[a], exponent);
  return ray;
}

Ray with_denormal_parts(TargetPicker& pick) {
  Ray ray = pick.axis_parallel(pick.inside());
  for (int a = 0; a < 3; ++a)
    if (ray.dir[a] == 0) ray.dir[a] = random_over_exponents(pick.rng(), -149, -127);
  return ray;
}

// From a point of the plane to another, rounded: exactly in the plane where it is parallel to two axes.
Ray in_triangles_plane(TargetPicker& pick) {
  const Triangle t = pick.triangle();
  const auto eighths = [&] { return static_cast<float>(pick.rng().next_below(25)) * 0.125f - 1.0f; };
  const auto point = [&](float u, float v) { return t.v0 + (t.v1 - t.v0) * u + (t.v2 - t.v0) * v; };
  const float u0 = eighths(), v0 = eighths(), u1 = eighths(), v1 = eighths();
  if (pick.rng().next_below(3) == 0) return aim(point(u0, 0), point(u1, 0));  // along an edge
  return aim(point(u0, v0), point(u1, v1));
}

Ray no_ray(TargetPicker& pick) {
  static const std::vector<Ray> kInvalid = invalid_rays();
  const std::uint32_t which = pick.rng().next_below(static_cast<std::uint32_t>(2 * kInvalid.size()));
  if (which < kInvalid.size()) return kInvalid[which];
  Ray ray = aim_from_around(pick, pick.inside());
  float& bad = which % 2 == 0 ? ray.org[pick.axis()] : ray.dir[pick.axis()];
  constexpr float kBad[] = {std::numeric_limits<float>::quiet_NaN(), kInfinity, -kInfinity, kLargest, -2e18f};
  bad = kBad[pick.rng().next_below(std::size(kBad))];
  return ray;
}

Ray make(RayKind kind, TargetPicker& pick) {
  Ray ray;
  switch (kind) {
    case RayKind::at_vertices:
      return aim_from_around(pick, pick.vertex());
    case RayKind::beside_vertices:
      return aim_from_around(pick, pick.beside(pick.vertex()));
    case RayKind::at_edges:
      return aim_from_around(pick, pick.on_edge());
    case RayKind::beside_edges:
      return aim_from_around(pick, pick.beside(pick.on_edge()));
    case RayKind::in_split_planes:
      return in_split_plane(pick);
    case RayKind::along_boxes:
      return along_box(pick);
    case RayKind::axis_parallel:
      return pick.axis_parallel(any_target(pick));
    case RayKind::from_surfaces:
      return {.org = pick.rng().next_below(2) != 0 ? pick.inside() : pick.on_edge(), .dir = random_in_cube(pick.rng(), 1)};
    case RayKind::from_vertices:
      return {.org = pick.vertex(), .dir = random_in_cube(pick.rng(), 1)};
    case RayKind::from_planes:
      return from_plane(pick);
    case RayKind::hit_at_t_min:
      ray = aim_from_around(pick, any_target(pick));
      ray.t_min = about_one(pick);
      return ray;
    case RayKind::hit_at_t_max:
      ray = aim_from_around(pick, any_target(pick));
      ray.t_max = about_one(pick);
      return ray;
    case RayKind::all_intervals:
      return with_interval(pick);
    case RayKind::empty_intervals:
      return with_empty_interval(pick);
    case RayKind::any_length:
      return with_any_length(pick);
    case RayKind::denormal_parts:
      return with_denormal_parts(pick);
    case RayKind::in_triangles_planes:
      return in_triangles_plane(pick);
    default:
      return no_ray(pick);
  }
}

std::vector<Ray> joined(std::vector<Ray> a, const std::vector<Ray>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

}  // namespace

std::vector<Ray> rays_of_kind(RayKind kind, const TriangleMesh& mesh, std::size_t count, std::uint64_t seed) {
  if (kind == RayKind::mixed)
    return joined(stress_rays(mesh, count - count / 2, seed), cell_stress_rays(mesh, count / 2, seed));
  if (kind == RayKind::far_away)
    return joined(far_rays(mesh, 1e2f, count - count / 2, seed), far_rays(mesh, 1e3f, count / 2, seed + 1));
  if (kind == RayKind::farther_away)
    return joined(far_rays(mesh, 1e4f, count - count / 2, seed), far_rays(mesh, 1e6f, count / 2, seed + 1));
  const bool traceable = kind != RayKind::empty_intervals && kind != RayKind::not_rays;
  const RayTargets targets = ray_targets(mesh);
  std::vector<Ray> rays;
  rays.reserve(count);
  for (std::uint64_t i = 0; i < count; ++i) {
    TargetPicker pick(targets, seed, i);
    const Ray ray = make(kind, pick);
    if (!traceable || is_traceable(ray)) rays.push_back(ray);
  }
  return rays;
}

}  // namespace accel::validation
