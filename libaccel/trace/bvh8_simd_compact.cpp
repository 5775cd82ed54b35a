#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "libaccel/trace/bvh8_simd_compact.cpp"
#include <hwy/foreach_target.h>
// Above all other headers.
#include <hwy/highway.h>

#include "libaccel/trace/bvh8_simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace accel {
namespace HWY_NAMESPACE {
namespace {

Bvh8Functions<CompactBvh8Node> compact() { return functions_of<CompactBvh8Node, PaddedSlabs, Watertight>(); }

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace accel
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace accel {
HWY_EXPORT(compact);

Bvh8Functions<CompactBvh8Node> Bvh8Simd<CompactBvh8Node, PaddedSlabs, Watertight>::functions() {
  return HWY_DYNAMIC_DISPATCH(compact)();
}
}  // namespace accel
#endif
