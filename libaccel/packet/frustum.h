// The frustum of a packet of rays: two rectangles perpendicular to the axis along which all of them run. Garanzha and Loop 2010
// [GL10], section 3.2, after Overbeck et al. 2008, "Large Ray Packets for Real-time Whitted Ray Tracing".
//
// Every ray of the packet runs along the dominant axis, in the same direction, so its other two coordinates are linear in that
// one. The planes of the rectangles are the ends of what the packet's intervals cover of the scene; the rectangles bound all
// rays there, and hence straight lines between their sides bound all rays in between.
//
// Conservative. No box is culled that the box test of single rays (trace/box_pair.h) lets any ray of the packet enter, so that
// what a packet finds is what its rays would find. That test accepts a box if a point of the ray lies within 2 gamma(8) +
// 3 gamma(3) < 32 u of the distance between origin and box, and the arithmetic here has an error of less than 16 u of the
// largest coordinate in it. Both are covered by moving all sides outwards by kSlack = 128 u of the largest coordinate, where
// origins, which differ from it by less than twice that coordinate, count too.
#pragma once

#include <cstdint>
#include <limits>

#include "libaccel/core/aabb.h"
#include "libaccel/core/float_bounds.h"
#include "libaccel/core/ray.h"
#include "libaccel/structure/octo_node.h"

namespace accel {

// Rays of one packet have the same dominant axis and the same sign along it: one of six faces of a cube. kNoFace: the ray takes
// no part in packets, because nothing can trace it, or because 1 / dir may
// overflow.
inline constexpr std::uint32_t kNoFace = 6;
ACCEL_HD std::uint32_t face_of(const Ray& ray) {
  if (!is_traceable(ray)) return kNoFace;
  constexpr float kLeast = std::numeric_limits<float>::min();
  for (int a = 0; a < 3; ++a)
    if (ray.dir[a] != 0 && ray.dir[a] < kLeast && ray.dir[a] > -kLeast) return kNoFace;
  const int axis = largest_axis(ray.dir);
  return 2u * static_cast<std::uint32_t>(axis) + (ray.dir[axis] < 0 ? 1u : 0u);
}

namespace detail {

struct Range {
  float lo = std::numeric_limits<float>::infinity(), hi = -std::numeric_limits<float>::infinity();

  ACCEL_HD void extend(float x) { lo = min_of(x, lo), hi = max_of(x, hi); }
  ACCEL_HD float magnitude() const { return max_of(lo < 0 ? -lo : lo, hi < 0 ? -hi : hi); }
};

}  // namespace detail

inline constexpr float kFrustumSlack = 128 * kUnitRoundoff;

struct Frustum {
  // A side: the lower and the upper bound of a coordinate at the first plane, and what they grow by per unit of the axis.
  struct Side {
    float lower, lower_slope, upper, upper_slope;
  };

  std::uint32_t face;
  std::uint32_t signs;  // bit a: axis a is negative in most of the rays; the order of children
  float begin, end;     // on the axis, begin <= end; else the frustum is empty
  Side side[2];         // of the axes after the dominant one, cyclically
  float slack;

  ACCEL_HD int axis() const { return static_cast<int>(face >> 1); }
  ACCEL_HD int side_axis(int s) const { return (axis() + 1 + s) % 3; }

  // Whether the frustum may meet the box. NaN culls nothing.
  ACCEL_HD bool meets(const Aabb& box) const {
    const float nearest = max_of(box.lo[axis()], begin), farthest = min_of(box.hi[axis()], end);
    bool culled = nearest > farthest + slack;
    for (int s = 0; s < 2; ++s) {
      const float from = nearest - begin, to = farthest - begin;
      const Side& at = side[s];
      const float lower = at.lower + min_of(at.lower_slope * from, at.lower_slope * to);
      const float upper = at.upper + max_of(at.upper_slope * from, at.upper_slope * to);
      culled = culled || lower > box.hi[side_axis(s)] || upper < box.lo[side_axis(s)];
    }
    return !culled;
  }

  // The lines between two ranges, `length` apart. Where planes are the same but for rounding, it is flat.
  ACCEL_HD static Side side_between(detail::Range first, detail::Range last, float length, bool is_flat, float slack) {
    if (is_flat) return {min_of(first.lo, last.lo) - slack, 0, max_of(first.hi, last.hi) + slack, 0};
    return {first.lo - slack, (last.lo - first.lo) / length, first.hi + slack, (last.hi - first.hi) / length};
  }

  // Between two planes, with the ranges of the side coordinates there; `origins` is their largest coordinate.
  ACCEL_HD void set_sides(float first_plane, float last_plane, const detail::Range* first, const detail::Range* last,
                          float origins) {
    begin = first_plane, end = last_plane;
    float largest = max_of(origins, detail::Range{begin, begin}.magnitude());
    largest = max_of(largest, detail::Range{end, end}.magnitude());
    for (int s = 0; s < 2; ++s) largest = max_of(largest, max_of(first[s].magnitude(), last[s].magnitude()));
    slack = max_of(kFrustumSlack * largest, std::numeric_limits<float>::min());
    const float length = end - begin;
    for (int s = 0; s < 2; ++s) side[s] = side_between(first[s], last[s], length, !(length > slack), slack);
  }

  // The longest side of its rectangles.
  ACCEL_HD float width() const {
    float widest = 0;
    for (const Side& at : side) {
      const float first = at.upper - at.lower;
      widest = max_of(widest, max_of(first, first + (at.upper_slope - at.lower_slope) * (end - begin)));
    }
    return widest;
  }
};

// Of `count` > 0 rays of one face, ray_at(i), in a scene within `bounds`.
template <class RayAt>
ACCEL_HD Frustum make_frustum(std::uint32_t face, std::uint32_t count, const RayAt& ray_at, const Aabb& bounds) {
  Frustum frustum{.face = face};
  const int axis = frustum.axis();
  detail::Range depth;
  float origins = 0;
  int negative[3] = {};
  for (std::uint32_t i = 0; i < count; ++i) {
    const Ray ray = ray_at(i);
    depth.extend(ray.org[axis] + ray.dir[axis] * max_of(ray.t_min, 0.0f));
    depth.extend(ray.org[axis] + ray.dir[axis] * min_of(ray.t_max, std::numeric_limits<float>::max()));
    for (int a = 0; a < 3; ++a) {
      origins = max_of(origins, ray.org[a] < 0 ? -ray.org[a] : ray.org[a]);
      negative[a] += ray.dir[a] < 0 ? 1 : 0;
    }
  }
  for (int a = 0; a < 3; ++a) frustum.signs |= (2 * negative[a] > static_cast<int>(count) ? 1u : 0u) << a;
  const float begin = max_of(depth.lo, bounds.lo[axis]), end = min_of(depth.hi, bounds.hi[axis]);

  detail::Range first[2], last[2];
  for (std::uint32_t i = 0; i < count; ++i) {
    const Ray ray = ray_at(i);
    for (int s = 0; s < 2; ++s) {
      const int a = frustum.side_axis(s);
      const float slope = ray.dir[a] / ray.dir[axis];
      first[s].extend(ray.org[a] + slope * (begin - ray.org[axis]));
      last[s].extend(ray.org[a] + slope * (end - ray.org[axis]));
    }
  }
  frustum.set_sides(begin, end, first, last, origins);
  return frustum;
}

}  // namespace accel
