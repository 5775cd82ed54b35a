// The rays of a packet in SIMD lanes. The guard lets the header through once for each target that Highway compiles.
#if defined(ACCEL_PACKET_SIMD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ACCEL_PACKET_SIMD_INL_H
#undef ACCEL_PACKET_SIMD_INL_H
#else
#define ACCEL_PACKET_SIMD_INL_H
#endif

#include <hwy/highway.h>

#include <cstdint>
#include <limits>

#include "libaccel/packet/localized.h"

HWY_BEFORE_NAMESPACE();
namespace accel {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
// At most 16 rays a group: what any machine has, and what fits the bits of a group.
const hn::CappedTag<float, 16> kFloats;
const hn::RebindToUnsigned<decltype(kFloats)> kWords;
using Floats = decltype(hn::Zero(kFloats));
using Words = decltype(hn::Zero(kWords));
using Mask = decltype(hn::Eq(hn::Zero(kFloats), hn::Zero(kFloats)));

HWY_INLINE Floats set(float x) { return hn::Set(kFloats, x); }
HWY_INLINE Floats load(const float* from) { return hn::Load(kFloats, from); }
// min_of(), max_of(): the second where one is NaN.
HWY_INLINE Floats least(Floats a, Floats b) { return hn::IfThenElse(hn::Lt(a, b), a, b); }
HWY_INLINE Floats most(Floats a, Floats b) { return hn::IfThenElse(hn::Gt(a, b), a, b); }

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// The rays of a packet and what they have hit. Lanes without a ray, and rays that have their answer, have t = -infinity and
// enter nothing.
struct alignas(64) Packet {
  float org[3][kMaxPacketSize], dir[3][kMaxPacketSize], inv[3][kMaxPacketSize];
  float shear_x[kMaxPacketSize], shear_y[kMaxPacketSize];
  float t_min[kMaxPacketSize];
  float t[kMaxPacketSize], u[kMaxPacketSize], v[kMaxPacketSize];
  std::uint32_t prim_id[kMaxPacketSize];
  const Ray* rays[kMaxPacketSize];

  std::uint32_t size, lanes;  // of rays, and with those that fill the last group
  int kx, ky, kz;             // as in Watertight::RayData
};

template <class Vector>
HWY_INLINE float least_lane(Vector v) {
  return hn::GetLane(hn::MinOfLanes(kFloats, v));
}
template <class Vector>
HWY_INLINE float most_lane(Vector v) {
  return hn::GetLane(hn::MaxOfLanes(kFloats, v));
}

HWY_INLINE void load_rays(const Ray* rays, const std::uint32_t* ids, std::uint32_t size, Packet& p) {
  const auto width = static_cast<std::uint32_t>(hn::Lanes(kFloats));
  p.size = size, p.lanes = (size + width - 1) / width * width;
  for (std::uint32_t i = 0; i < p.lanes; ++i) {
    const Ray& ray = rays[ids[i < size ? i : size - 1]];
    p.org[0][i] = ray.org.x, p.org[1][i] = ray.org.y, p.org[2][i] = ray.org.z;
    p.dir[0][i] = ray.dir.x, p.dir[1][i] = ray.dir.y, p.dir[2][i] = ray.dir.z;
    p.t_min[i] = ray.t_min, p.t[i] = ray.t_max, p.rays[i] = &ray;
  }
  for (std::uint32_t i = 0; i < p.lanes; i += width) {
    hn::Store(most(load(p.t_min + i), set(0)), kFloats, p.t_min + i);
    hn::Store(least(load(p.t + i), set(std::numeric_limits<float>::max())), kFloats, p.t + i);
  }
  for (std::uint32_t i = size; i < p.lanes; ++i) p.t_min[i] = kInfinity, p.t[i] = -kInfinity;
}

// Where a side coordinate of the rays from lane i on is at a plane of the dominant axis.
HWY_INLINE Floats at_plane(const Packet& p, std::uint32_t i, int axis, int side_axis, float plane) {
  const Floats slope = hn::Div(load(p.dir[side_axis] + i), load(p.dir[axis] + i));
  return hn::Add(load(p.org[side_axis] + i), hn::Mul(slope, hn::Sub(set(plane), load(p.org[axis] + i))));
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace accel
HWY_AFTER_NAMESPACE();

#endif
