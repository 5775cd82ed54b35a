#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "libaccel/packet/frustums_simd.cpp"
#include <hwy/foreach_target.h>
// Above all other headers.
#include <hwy/highway.h>

#include <bit>
#include <limits>

#include "libaccel/packet/frustum_simd-inl.h"
#include "libaccel/packet/frustums_simd.h"
#include "libaccel/packet/packet_simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace accel {
namespace HWY_NAMESPACE {
namespace {

void find_faces(const Ray* rays, std::size_t count, std::uint8_t* faces) {
  const std::size_t width = hn::Lanes(kFloats), whole = count - count % width;
  const hn::Rebind<std::int32_t, decltype(kFloats)> ints;
  const hn::Rebind<std::uint8_t, decltype(kFloats)> bytes;
  for (std::size_t i = 0; i < whole; i += width) {
    const Words some = faces_of(load_lanes([&](std::uint32_t k) -> const Ray& { return rays[i + k]; }));
    hn::StoreU(hn::DemoteTo(bytes, hn::BitCast(ints, some)), bytes, faces + i);
  }
  for (std::size_t i = whole; i < count; ++i) faces[i] = static_cast<std::uint8_t>(face_of(rays[i]));
}

void make(const LocalizedBatch& batch, const std::uint8_t* faces, const Aabb& bounds, Frustum* frustums) {
  Packet packet;
  for (std::size_t i = 0; i < batch.count; ++i) {
    const std::uint32_t first = batch.packets[batch.active[i]], end = batch.packets[batch.active[i] + 1];
    load_rays(batch.rays, batch.ids + first, end - first, faces[first] >> 1, packet);
    frustums[i] = frustum_of(packet, faces[first], bounds);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace accel
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace accel {
HWY_EXPORT(find_faces);
HWY_EXPORT(make);

void find_faces_simd(const Ray* rays, std::size_t count, std::uint8_t* faces) {
  HWY_DYNAMIC_DISPATCH(find_faces)(rays, count, faces);
}

void make_frustums_simd(const LocalizedBatch& batch, const std::uint8_t* faces, const Aabb& bounds, Frustum* frustums) {
  HWY_DYNAMIC_DISPATCH(make)(batch, faces, bounds, frustums);
}
}  // namespace accel
#endif
