#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "libaccel/trace/bvh8_simd.cpp"
#include <hwy/foreach_target.h>
// Above all other headers.
#include <hwy/highway.h>

#include "libaccel/trace/bvh8_simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace accel {
namespace HWY_NAMESPACE {
namespace {

Bvh8Functions<Bvh8Node> watertight() { return functions_of<Bvh8Node, PaddedSlabs, Watertight>(); }

const char* target_name() { return hwy::TargetName(HWY_TARGET); }

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace accel
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace accel {
HWY_EXPORT(watertight);
HWY_EXPORT(target_name);

const char* bvh8_simd_target() { return HWY_DYNAMIC_DISPATCH(target_name)(); }
Bvh8Functions<Bvh8Node> Bvh8Simd<Bvh8Node, PaddedSlabs, Watertight>::functions() { return HWY_DYNAMIC_DISPATCH(watertight)(); }
}  // namespace accel
#endif
