// Rays through one point, as those of a camera: a group of them is a rectangle of slopes, and so is what a box covers as seen
// from there. Eight boxes are projected at once, and each is compared with all groups of a packet at once: few groups are left
// that ask it in vain. The guard lets the header through once for each target that Highway compiles.
//
// Slopes are coordinates along the axes kx and ky per unit of depth, the distance from the point along the axis kz. Depths of
// rays are not negative, and slopes are at most 1 in magnitude, for kz is the rays' dominant axis.
//
// Conservative, as frustums are (packet/frustum.h): boxes are enlarged by the slack of a frustum, 128 u of the largest
// coordinate. What the box test allows for takes half of it, and the rounding of planes relative to the point less than 8 u.
// The errors of a ray's slope, of a reciprocal and of a product are less than 8 u of slopes up to 1, which is 16 u of the
// largest coordinate at depths up to twice that.
//
// NaN. A box that rays enter has a farthest depth beyond 0, once it is enlarged. So of what counts, only the product of 0 and
// the reciprocal of a nearest depth of 0 is NaN; it comes first in least() and most(), which then give the other.
#if defined(ACCEL_PENCIL_SIMD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ACCEL_PENCIL_SIMD_INL_H
#undef ACCEL_PENCIL_SIMD_INL_H
#else
#define ACCEL_PENCIL_SIMD_INL_H
#endif

#include <hwy/highway.h>

#include <cstdint>

#include "libaccel/packet/frustum.h"
#include "libaccel/packet/packet_simd-inl.h"
#include "libaccel/structure/bvh8.h"

HWY_BEFORE_NAMESPACE();
namespace accel {
namespace HWY_NAMESPACE {
namespace {

// What the children of a node cover: ranges of slopes along kx and ky.
struct alignas(64) ChildSlopes {
  float lower[2][kBvh8Arity], upper[2][kBvh8Arity];
};

class alignas(64) Pencil {
 public:
  // Of a packet whose rays have one origin, with its frustum.
  HWY_INLINE void begin(const Packet& p, const Frustum& frustum) {
    kz_ = p.kz, is_backward_ = (frustum.face & 1u) != 0, slack_ = frustum.slack;
    const float apex = p.origin[kz_];
    begin_ = is_backward_ ? apex - frustum.end : frustum.begin - apex;
    end_ = is_backward_ ? apex - frustum.begin : frustum.end - apex;
    for (int a = 0; a < 3; ++a) apex_[a] = p.origin[a];
    for (int s = 0; s < 2; ++s) {
      Floats lower = set(kInfinity), upper = set(-kInfinity);
      for (std::uint32_t i = 0, g = 0; i < p.lanes; i += width(), ++g) {
        const Floats shear = load(p.shear[s] + i), slope = is_backward_ ? hn::Neg(shear) : shear;
        lower = least(slope, lower), upper = most(slope, upper);
        group_lower_[s][g] = least_lane(slope), group_upper_[s][g] = most_lane(slope);
      }
      lower_[s] = least_lane(lower), upper_[s] = most_lane(upper);
    }
  }

  // Projects the children of a node. Bit c of the result: whether the packet may meet child c.
  HWY_INLINE std::uint32_t project(const Bvh8Node& node, ChildSlopes& slopes) const {
    const hn::CappedTag<float, kBvh8Arity> boxes;
    const auto slack = hn::Set(boxes, slack_), zero = hn::Zero(boxes), one = hn::Set(boxes, 1);
    std::uint32_t met = 0;
    for (std::uint32_t first = 0; first < kBvh8Arity; first += static_cast<std::uint32_t>(hn::Lanes(boxes))) {
      const auto plane = [&](int axis, int side) HWY_ATTR {
        return hn::Sub(hn::Load(boxes, node.planes[axis][side] + first), hn::Set(boxes, apex_[axis]));
      };
      const auto nearest = hn::Sub(is_backward_ ? hn::Neg(plane(kz_, 1)) : plane(kz_, 0), slack);
      const auto farthest = hn::Add(is_backward_ ? hn::Neg(plane(kz_, 0)) : plane(kz_, 1), slack);
      auto is_met = hn::And(hn::Gt(farthest, zero), hn::Ge(farthest, hn::Set(boxes, begin_)));
      is_met = hn::And(is_met, hn::Le(nearest, hn::Set(boxes, end_)));
      const auto per_nearest = hn::Div(one, most(nearest, zero)), per_farthest = hn::Div(one, farthest);
      for (int s = 0; s < 2; ++s) {
        const int axis = (kz_ + 1 + s) % 3;
        const auto x0 = hn::Sub(plane(axis, 0), slack), x1 = hn::Add(plane(axis, 1), slack);
        const auto lower = least(hn::Mul(x0, per_nearest), hn::Mul(x0, per_farthest));
        const auto upper = most(hn::Mul(x1, per_nearest), hn::Mul(x1, per_farthest));
        is_met = hn::And(is_met, hn::And(hn::Le(lower, hn::Set(boxes, upper_[s])), hn::Ge(upper, hn::Set(boxes, lower_[s]))));
        hn::Store(lower, boxes, slopes.lower[s] + first), hn::Store(upper, boxes, slopes.upper[s] + first);
      }
      std::uint8_t bits[8] = {};
      hn::StoreMaskBits(boxes, is_met, bits);
      met |= static_cast<std::uint32_t>(bits[0]) << first;
    }
    return met;
  }

  // Those of the groups that may meet child c.
  HWY_INLINE GroupBits groups_that_meet(const ChildSlopes& slopes, std::uint32_t c, GroupBits groups) const {
    GroupBits met = 0;
    for (std::uint32_t g = 0; g < kMostGroups && groups >> g != 0; g += width()) {
      Mask is_met = hn::Le(load(group_lower_[0] + g), set(slopes.upper[0][c]));
      is_met = hn::And(is_met, hn::Ge(load(group_upper_[0] + g), set(slopes.lower[0][c])));
      is_met = hn::And(is_met, hn::Le(load(group_lower_[1] + g), set(slopes.upper[1][c])));
      is_met = hn::And(is_met, hn::Ge(load(group_upper_[1] + g), set(slopes.lower[1][c])));
      std::uint8_t bits[8] = {};
      hn::StoreMaskBits(kFloats, is_met, bits);
      met |= static_cast<GroupBits>(bits[0] | bits[1] << 8) << g;
    }
    return met & groups;
  }

 private:
  float group_lower_[2][kMostGroups], group_upper_[2][kMostGroups];
  float lower_[2], upper_[2];  // of the packet
  float begin_, end_;          // depths of the packet
  float apex_[3];
  int kz_;
  bool is_backward_;  // rays go down the axis kz
  float slack_;       // of boxes
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace accel
HWY_AFTER_NAMESPACE();

#endif
