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

namespace {

bool are_alike(const Ray& a, const Ray& b) {
  const auto dot = [](Vec3 v, Vec3 w) {
    return static_cast<double>(v.x) * w.x + static_cast<double>(v.y) * w.y + static_cast<double>(v.z) * w.z;
  };
  const double ab = dot(a.dir, b.dir);
  return ab > 0 && ab * ab > 0.9 * dot(a.dir, a.dir) * dot(b.dir, b.dir);
}

}  // namespace

bool are_alike(std::span<const Ray> rays) {
  const std::size_t stride = rays.size() / 64 + 1;
  int alike = 0;
  for (std::size_t i = 1; i < rays.size(); i += stride) alike += are_alike(rays[i - 1], rays[i]) ? 1 : -1;
  return alike >= 0;
}

const char* bvh8_simd_target() { return HWY_DYNAMIC_DISPATCH(target_name)(); }
Bvh8Functions<Bvh8Node> Bvh8Simd<Bvh8Node, PaddedSlabs, Watertight>::functions() { return HWY_DYNAMIC_DISPATCH(watertight)(); }
}  // namespace accel
#endif
