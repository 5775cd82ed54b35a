#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "libaccel/packet/culling_simd.cpp"
#include <hwy/foreach_target.h>
// Above all other headers.
#include <hwy/highway.h>

#include "libaccel/packet/culling_simd.h"
#include "libaccel/packet/frustum_boxes_simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace accel {
namespace HWY_NAMESPACE {
namespace {

void cull(const OctoNode* nodes, const Frustum* frustums, const std::uint32_t* frustum, const std::uint32_t* place,
          std::size_t count, std::uint8_t* masks) {
  for (std::size_t i = 0; i < count; ++i) {
    if (is_leaf(place[i])) continue;
    const OctoNode& node = nodes[place[i]];
    masks[i] = static_cast<std::uint8_t>(boxes_met(node, frustums[frustum[i]]) & node.child_mask);
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
