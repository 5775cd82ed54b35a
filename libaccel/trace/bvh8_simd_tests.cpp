#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "libaccel/trace/bvh8_simd_tests.cpp"
#include <hwy/foreach_target.h>
// Above all other headers.
#include <hwy/highway.h>

#include "libaccel/trace/bvh8_simd-inl.h"
#include "libaccel/trace/triangle_block_tests_simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace accel {
namespace HWY_NAMESPACE {
namespace {

Bvh8Functions<Bvh8Node> moeller_trumbore() { return functions_of<Bvh8Node, PaddedSlabs, MoellerTrumbore>(); }
Bvh8Functions<Bvh8Node> woop() { return functions_of<Bvh8Node, PaddedSlabs, Woop>(); }
Bvh8Functions<Bvh8Node> woop_kahan() { return functions_of<Bvh8Node, PaddedSlabs, WoopKahan>(); }
Bvh8Functions<Bvh8Node> pluecker() { return functions_of<Bvh8Node, PaddedSlabs, Pluecker>(); }

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace accel
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace accel {
HWY_EXPORT(moeller_trumbore);
HWY_EXPORT(woop);
HWY_EXPORT(woop_kahan);
HWY_EXPORT(pluecker);

Bvh8Functions<Bvh8Node> Bvh8Simd<Bvh8Node, PaddedSlabs, MoellerTrumbore>::functions() {
  return HWY_DYNAMIC_DISPATCH(moeller_trumbore)();
}
Bvh8Functions<Bvh8Node> Bvh8Simd<Bvh8Node, PaddedSlabs, Woop>::functions() { return HWY_DYNAMIC_DISPATCH(woop)(); }
Bvh8Functions<Bvh8Node> Bvh8Simd<Bvh8Node, PaddedSlabs, WoopKahan>::functions() { return HWY_DYNAMIC_DISPATCH(woop_kahan)(); }
Bvh8Functions<Bvh8Node> Bvh8Simd<Bvh8Node, PaddedSlabs, Pluecker>::functions() { return HWY_DYNAMIC_DISPATCH(pluecker)(); }
}  // namespace accel
#endif
