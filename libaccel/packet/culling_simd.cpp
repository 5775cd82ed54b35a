#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "libaccel/packet/culling_simd.cpp"
#include <hwy/foreach_target.h>
// Above all other headers.
#include <hwy/highway.h>

#include "libaccel/packet/culling_simd.h"

HWY_BEFORE_NAMESPACE();
namespace accel {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
const hn::CappedTag<float, kOctoArity> kFloats;
using Vector = decltype(hn::Zero(kFloats));

// Frustum::meets() for the children from `first` on: bit 0 for child `first`.
std::uint32_t cull_children(const OctoNode& node, const Frustum& frustum, std::uint32_t first) {
  const int axis = frustum.axis();
  const Vector begin = hn::Set(kFloats, frustum.begin), end = hn::Set(kFloats, frustum.end);
  const Vector lower = hn::Load(kFloats, node.lower[axis] + first), upper = hn::Load(kFloats, node.upper[axis] + first);
  const Vector nearest = hn::IfThenElse(hn::Gt(lower, begin), lower, begin);
  const Vector farthest = hn::IfThenElse(hn::Lt(upper, end), upper, end);
  auto culled = hn::Gt(nearest, hn::Add(farthest, hn::Set(kFloats, frustum.slack)));
  const Vector from = hn::Sub(nearest, begin), to = hn::Sub(farthest, begin);
  for (int s = 0; s < 2; ++s) {
    const Frustum::Side& side = frustum.side[s];
    const int a = frustum.side_axis(s);
    const Vector lower_slope = hn::Set(kFloats, side.lower_slope), upper_slope = hn::Set(kFloats, side.upper_slope);
    const Vector lower_from = hn::Mul(lower_slope, from), lower_to = hn::Mul(lower_slope, to);
    const Vector upper_from = hn::Mul(upper_slope, from), upper_to = hn::Mul(upper_slope, to);
    const Vector least =
        hn::Add(hn::Set(kFloats, side.lower), hn::IfThenElse(hn::Lt(lower_from, lower_to), lower_from, lower_to));
    const Vector most =
        hn::Add(hn::Set(kFloats, side.upper), hn::IfThenElse(hn::Gt(upper_from, upper_to), upper_from, upper_to));
    culled = hn::Or(culled, hn::Gt(least, hn::Load(kFloats, node.upper[a] + first)));
    culled = hn::Or(culled, hn::Lt(most, hn::Load(kFloats, node.lower[a] + first)));
  }
  std::uint8_t bits[8] = {};
  hn::StoreMaskBits(kFloats, hn::Not(culled), bits);
  return bits[0];
}

void cull(const OctoNode* nodes, const Frustum* frustums, const std::uint32_t* frustum, const std::uint32_t* place,
          std::size_t count, std::uint8_t* masks) {
  const auto lanes = static_cast<std::uint32_t>(hn::Lanes(kFloats));
  for (std::size_t i = 0; i < count; ++i) {
    if (is_leaf(place[i])) continue;
    std::uint32_t mask = 0;
    for (std::uint32_t c = 0; c < kOctoArity; c += lanes) mask |= cull_children(nodes[place[i]], frustums[frustum[i]], c) << c;
    masks[i] = static_cast<std::uint8_t>(mask & nodes[place[i]].child_mask);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace accel
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace accel {
HWY_EXPORT(cull);

void cull_simd(const OctoNode* nodes, const Frustum* frustums, const std::uint32_t* frustum, const std::uint32_t* place,
               std::size_t count, std::uint8_t* masks) {
  HWY_DYNAMIC_DISPATCH(cull)(nodes, frustums, frustum, place, count, masks);
}
}  // namespace accel
#endif
