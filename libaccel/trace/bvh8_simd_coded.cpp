#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "libaccel/trace/bvh8_simd_coded.cpp"
#include <hwy/foreach_target.h>
// Above all other headers.
#include <hwy/highway.h>

#include "libaccel/trace/bvh8_simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace accel {
namespace HWY_NAMESPACE {
namespace {

Bvh8Functions<ByteBvh8Node> bytes() { return functions_of<ByteBvh8Node, PaddedSlabs, Watertight>(); }
Bvh8Functions<HalfBvh8Node> halves() { return functions_of<HalfBvh8Node, PaddedSlabs, Watertight>(); }

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace accel
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace accel {
HWY_EXPORT(bytes);
HWY_EXPORT(halves);

Bvh8Functions<ByteBvh8Node> Bvh8Simd<ByteBvh8Node, PaddedSlabs, Watertight>::functions() {
  return HWY_DYNAMIC_DISPATCH(bytes)();
}
Bvh8Functions<HalfBvh8Node> Bvh8Simd<HalfBvh8Node, PaddedSlabs, Watertight>::functions() {
  return HWY_DYNAMIC_DISPATCH(halves)();
}
}  // namespace accel
#endif
