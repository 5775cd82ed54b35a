#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "libaccel/trace/bvh8_simd_slabs.cpp"
#include <hwy/foreach_target.h>
// Above all other headers.
#include <hwy/highway.h>

#include "libaccel/trace/bvh8_simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace accel {
namespace HWY_NAMESPACE {
namespace {

Bvh8Functions<Bvh8Node> naive() { return functions_of<Bvh8Node, NaiveSlabs, Watertight>(); }
Bvh8Functions<Bvh8Node> fused() { return functions_of<Bvh8Node, FusedSlabs, Watertight>(); }

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace accel
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace accel {
HWY_EXPORT(naive);
HWY_EXPORT(fused);

Bvh8Functions<Bvh8Node> Bvh8Simd<Bvh8Node, NaiveSlabs, Watertight>::functions() { return HWY_DYNAMIC_DISPATCH(naive)(); }
Bvh8Functions<Bvh8Node> Bvh8Simd<Bvh8Node, FusedSlabs, Watertight>::functions() { return HWY_DYNAMIC_DISPATCH(fused)(); }
}  // namespace accel
#endif
