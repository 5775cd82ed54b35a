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

// The bits of |x|, whose order as integers is that of the numbers, below those of NaN.
HWY_INLINE Words bits_of_magnitude(Floats x) { return hn::BitCast(kWords, hn::Abs(x)); }

// face_of() (packet/frustum.h).
HWY_INLINE Words faces_of(const RayLanes& r) {
  constexpr auto kMost = std::bit_cast<std::uint32_t>(kMaxCoordinate);
  constexpr auto kLeast = std::bit_cast<std::uint32_t>(std::numeric_limits<float>::min());
  const Words one = hn::Set(kWords, 1);
  Words size[3], largest_org = hn::Zero(kWords), largest = largest_org, smallest = hn::Set(kWords, 0xffffffffu);
  for (int a = 0; a < 3; ++a) {
    largest_org = hn::Max(bits_of_magnitude(r.org[a]), largest_org);
    size[a] = bits_of_magnitude(r.dir[a]);
    largest = hn::Max(size[a], largest);
    smallest = hn::Min(hn::Sub(size[a], one), smallest);  // zeros are above all others
  }
  const Mask is_interval = hn::And(hn::Le(r.t_min, r.t_max), hn::Ge(r.t_max, hn::Zero(kFloats)));
  const auto is_outside = hn::Or(hn::Gt(hn::Max(largest, largest_org), hn::Set(kWords, kMost)),
                                 hn::Or(hn::Lt(smallest, hn::Set(kWords, kLeast - 1)), hn::Eq(largest, hn::Zero(kWords))));
  const auto has_face = hn::AndNot(is_outside, hn::RebindMask(kWords, is_interval));
  const auto is_x = hn::Eq(size[0], largest), is_y = hn::Eq(size[1], largest);
  const Words dir[3] = {hn::BitCast(kWords, r.dir[0]), hn::BitCast(kWords, r.dir[1]), hn::BitCast(kWords, r.dir[2])};
  const Words along = hn::IfThenElse(is_x, dir[0], hn::IfThenElse(is_y, dir[1], dir[2]));
  const Words axis = hn::IfThenElse(is_x, hn::Zero(kWords), hn::IfThenElse(is_y, hn::Set(kWords, 2), hn::Set(kWords, 4)));
  const Words face = hn::Or(axis, hn::ShiftRight<31>(along));
  return hn::IfThenElse(has_face, face, hn::Set(kWords, kNoFace));
}

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
