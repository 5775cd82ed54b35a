#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "libaccel/packet/frustums_simd.cpp"
#include <hwy/foreach_target.h>
// Above all other headers.
#include <hwy/highway.h>

#include "libaccel/packet/frustum_simd-inl.h"
#include "libaccel/packet/frustums_simd.h"
#include "libaccel/packet/packet_simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace accel {
namespace HWY_NAMESPACE {
namespace {

HWY_INLINE Mask within(Floats v, float limit) { return hn::Le(hn::Abs(v), set(limit)); }

// face_of() (packet/frustum.h).
HWY_INLINE Words faces_of(const RayLanes& r) {
  const Floats zero = hn::Zero(kFloats);
  Mask has_face = hn::And(hn::Le(r.t_min, r.t_max), hn::Ge(r.t_max, zero));
  Mask runs = hn::Lt(zero, zero);
  Floats size[3];
  for (int a = 0; a < 3; ++a) {
    size[a] = hn::Abs(r.dir[a]);
    const Mask is_zero = hn::Eq(r.dir[a], zero);
    has_face = hn::And(has_face, hn::And(within(r.org[a], kMaxCoordinate), within(r.dir[a], kMaxCoordinate)));
    has_face = hn::And(has_face, hn::Or(is_zero, hn::Ge(size[a], set(std::numeric_limits<float>::min()))));
    runs = hn::Or(runs, hn::Not(is_zero));
  }
  const Mask is_x = hn::And(hn::Ge(size[0], size[1]), hn::Ge(size[0], size[2])), is_y = hn::Ge(size[1], size[2]);
  const Floats along = hn::IfThenElse(is_x, r.dir[0], hn::IfThenElse(is_y, r.dir[1], r.dir[2]));
  const Words axis = hn::IfThenElse(hn::RebindMask(kWords, is_x), hn::Set(kWords, 0),
                                    hn::IfThenElse(hn::RebindMask(kWords, is_y), hn::Set(kWords, 2), hn::Set(kWords, 4)));
  const Words face = hn::Add(axis, hn::IfThenElseZero(hn::RebindMask(kWords, hn::Lt(along, zero)), hn::Set(kWords, 1)));
  return hn::IfThenElse(hn::RebindMask(kWords, hn::And(has_face, runs)), face, hn::Set(kWords, kNoFace));
}

void find_faces(const Ray* rays, std::size_t count, std::uint8_t* faces) {
  const std::size_t width = hn::Lanes(kFloats), whole = count - count % width;
  const hn::Rebind<std::int32_t, decltype(kFloats)> ints;
  const hn::Rebind<std::uint8_t, decltype(kFloats)> bytes;
  for (std::size_t i = 0; i < whole; i += width)
    hn::StoreU(hn::DemoteTo(bytes, hn::BitCast(ints, faces_of(load_lanes(rays + i, rays + i + width / 2)))), bytes, faces + i);
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
