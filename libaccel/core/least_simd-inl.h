// The lesser and the greater of vectors, lane by lane, as min_of() and max_of() (core/vec3.h) have them. The guard lets
// the header through once for each target that Highway compiles.
#if defined(ACCEL_LEAST_SIMD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ACCEL_LEAST_SIMD_INL_H
#undef ACCEL_LEAST_SIMD_INL_H
#else
#define ACCEL_LEAST_SIMD_INL_H
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace accel {
namespace HWY_NAMESPACE {
namespace {

// The second where one is NaN. What x86 does.
#if HWY_TARGET != HWY_SCALAR && HWY_TARGET != HWY_EMU128 && HWY_ARCH_X86
template <class V>
HWY_INLINE V least(V a, V b) {
  return hwy::HWY_NAMESPACE::Min(a, b);
}
template <class V>
HWY_INLINE V most(V a, V b) {
  return hwy::HWY_NAMESPACE::Max(a, b);
}
#else
template <class V>
HWY_INLINE V least(V a, V b) {
  return hwy::HWY_NAMESPACE::IfThenElse(hwy::HWY_NAMESPACE::Lt(a, b), a, b);
}
template <class V>
HWY_INLINE V most(V a, V b) {
  return hwy::HWY_NAMESPACE::IfThenElse(hwy::HWY_NAMESPACE::Gt(a, b), a, b);
}
#endif

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace accel
HWY_AFTER_NAMESPACE();

#endif
