// A frustum against eight boxes, one in each SIMD lane: Frustum::meets() (packet/frustum.h), bit for bit. The guard lets the
// header through once for each target that Highway compiles.
#if defined(ACCEL_FRUSTUM_BOXES_SIMD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ACCEL_FRUSTUM_BOXES_SIMD_INL_H
#undef ACCEL_FRUSTUM_BOXES_SIMD_INL_H
#else
#define ACCEL_FRUSTUM_BOXES_SIMD_INL_H
#endif

#include <hwy/highway.h>

#include <cstdint>

#include "libaccel/packet/frustum.h"
#include "libaccel/structure/bvh8.h"

HWY_BEFORE_NAMESPACE();
namespace accel {
namespace HWY_NAMESPACE {
namespace {

// The planes of a node's children on an axis, lower ones and upper ones.
HWY_INLINE const float* lower_planes(const OctoNode& node, int axis) { return node.lower[axis]; }
HWY_INLINE const float* upper_planes(const OctoNode& node, int axis) { return node.upper[axis]; }
HWY_INLINE const float* lower_planes(const Bvh8Node& node, int axis) { return node.planes[axis][0]; }
HWY_INLINE const float* upper_planes(const Bvh8Node& node, int axis) { return node.planes[axis][1]; }

// Bit c of the result: whether the frustum may meet the box of child c.
template <class Node>
HWY_INLINE std::uint32_t boxes_met(const Node& node, const Frustum& frustum) {
  namespace hn = hwy::HWY_NAMESPACE;
  static_assert(kOctoArity == 8 && kBvh8Arity == 8);
  const hn::CappedTag<float, 8> boxes;
  const int axis = frustum.axis();
  const auto begin = hn::Set(boxes, frustum.begin), end = hn::Set(boxes, frustum.end);
  std::uint32_t met = 0;
  for (std::uint32_t first = 0; first < 8; first += static_cast<std::uint32_t>(hn::Lanes(boxes))) {
    const auto lower = hn::Load(boxes, lower_planes(node, axis) + first),
               upper = hn::Load(boxes, upper_planes(node, axis) + first);
    const auto nearest = hn::IfThenElse(hn::Gt(lower, begin), lower, begin);
    const auto farthest = hn::IfThenElse(hn::Lt(upper, end), upper, end);
    auto culled = hn::Gt(nearest, hn::Add(farthest, hn::Set(boxes, frustum.slack)));
    const auto from = hn::Sub(nearest, begin), to = hn::Sub(farthest, begin);
    for (int s = 0; s < 2; ++s) {
      const Frustum::Side& side = frustum.side[s];
      const int a = frustum.side_axis(s);
      const auto lower_slope = hn::Set(boxes, side.lower_slope), upper_slope = hn::Set(boxes, side.upper_slope);
      const auto lower_from = hn::Mul(lower_slope, from), lower_to = hn::Mul(lower_slope, to);
      const auto upper_from = hn::Mul(upper_slope, from), upper_to = hn::Mul(upper_slope, to);
      const auto least =
          hn::Add(hn::Set(boxes, side.lower), hn::IfThenElse(hn::Lt(lower_from, lower_to), lower_from, lower_to));
      const auto most = hn::Add(hn::Set(boxes, side.upper), hn::IfThenElse(hn::Gt(upper_from, upper_to), upper_from, upper_to));
      culled = hn::Or(culled, hn::Gt(least, hn::Load(boxes, upper_planes(node, a) + first)));
      culled = hn::Or(culled, hn::Lt(most, hn::Load(boxes, lower_planes(node, a) + first)));
    }
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(boxes, hn::Not(culled), bits);
    met |= bits[0] << first;
  }
  return met;
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace accel
HWY_AFTER_NAMESPACE();

#endif
