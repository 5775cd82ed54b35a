// The frustum of a packet, with rays in SIMD lanes: make_frustum() (packet/frustum.h), bit for bit. The guard lets the header
// through once for each target that Highway compiles.
#if defined(ACCEL_FRUSTUM_SIMD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ACCEL_FRUSTUM_SIMD_INL_H
#undef ACCEL_FRUSTUM_SIMD_INL_H
#else
#define ACCEL_FRUSTUM_SIMD_INL_H
#endif

#include <hwy/highway.h>

#include <cstdint>

#include "libaccel/packet/frustum.h"
#include "libaccel/packet/packet_simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace accel {
namespace HWY_NAMESPACE {
namespace {

// Of rays that have been loaded, all of one face, in a scene within `bounds`; without those that have their answer.
HWY_INLINE Frustum frustum_of(const Packet& p, std::uint32_t face, const Aabb& bounds) {
  Frustum frustum{.face = face};
  const int axis = frustum.axis();
  Floats nearest = set(kInfinity), farthest = set(-kInfinity);
  std::size_t rays = 0, negative[3] = {};
  for (std::uint32_t i = 0; i < p.lanes; i += width()) {
    const Floats org = load(p.org[axis] + i), dir = load(p.dir[axis] + i);
    const Floats first = hn::Add(org, hn::Mul(dir, load(p.t_min + i))), last = hn::Add(org, hn::Mul(dir, load(p.t + i)));
    const auto is_ray = hn::Ge(load(p.t + i), set(0));
    nearest = hn::IfThenElse(is_ray, least(least(first, last), nearest), nearest);
    farthest = hn::IfThenElse(is_ray, most(most(first, last), farthest), farthest);
    rays += hn::CountTrue(kFloats, is_ray);
    for (int a = 0; a < 3; ++a)
      negative[a] += hn::CountTrue(kFloats, hn::And(is_ray, hn::Lt(load(p.dir[a] + i), hn::Zero(kFloats))));
  }
  for (int a = 0; a < 3; ++a) frustum.signs |= (2 * negative[a] > rays ? 1u : 0u) << a;
  const float begin = max_of(least_lane(nearest), bounds.lo[axis]), end = min_of(most_lane(farthest), bounds.hi[axis]);

  detail::Range first[2], last[2];
  for (int s = 0; s < 2; ++s) {
    Floats least_first = set(kInfinity), most_first = set(-kInfinity), least_last = least_first, most_last = most_first;
    for (std::uint32_t i = 0; i < p.lanes; i += width()) {
      const Floats x0 = at_plane(p, i, s, begin), x1 = at_plane(p, i, s, end);
      least_first = least(x0, least_first), most_first = most(x0, most_first);
      least_last = least(x1, least_last), most_last = most(x1, most_last);
    }
    first[s] = {least_lane(least_first), most_lane(most_first)}, last[s] = {least_lane(least_last), most_lane(most_last)};
  }
  frustum.set_sides(begin, end, first, last, p.largest_origin);
  return frustum;
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace accel
HWY_AFTER_NAMESPACE();

#endif
