// The rays of a packet in SIMD lanes. The guard lets the header through once for each target that Highway compiles.
#if defined(ACCEL_PACKET_SIMD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ACCEL_PACKET_SIMD_INL_H
#undef ACCEL_PACKET_SIMD_INL_H
#else
#define ACCEL_PACKET_SIMD_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
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

HWY_INLINE std::uint32_t width() { return static_cast<std::uint32_t>(hn::Lanes(kFloats)); }
HWY_INLINE Floats set(float x) { return hn::Set(kFloats, x); }
HWY_INLINE Floats load(const float* from) { return hn::Load(kFloats, from); }
// min_of(), max_of(): the second where one is NaN. What x86 does.
#if HWY_TARGET != HWY_SCALAR && HWY_TARGET != HWY_EMU128 && HWY_ARCH_X86
template <class V>
HWY_INLINE V least(V a, V b) {
  return hn::Min(a, b);
}
template <class V>
HWY_INLINE V most(V a, V b) {
  return hn::Max(a, b);
}
#else
template <class V>
HWY_INLINE V least(V a, V b) {
  return hn::IfThenElse(hn::Lt(a, b), a, b);
}
template <class V>
HWY_INLINE V most(V a, V b) {
  return hn::IfThenElse(hn::Gt(a, b), a, b);
}
#endif

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Groups of a packet, a vector of rays each, are the bits of a word.
using GroupBits = std::uint64_t;
constexpr std::uint32_t kMostGroups = 64;

// The rays of a packet and what they have hit. Lanes without a ray, and rays that have their answer, have t = -infinity and
// enter nothing.
struct alignas(64) Packet {
  float org[3][kMaxPacketSize], dir[3][kMaxPacketSize], inv[3][kMaxPacketSize];
  float shear[2][kMaxPacketSize];  // of Watertight::RayData: the slopes of the axes kx and ky along kz
  float t_min[kMaxPacketSize];
  float t[kMaxPacketSize], u[kMaxPacketSize], v[kMaxPacketSize];
  std::uint32_t prim_id[kMaxPacketSize];

  const Ray* rays;            // of the batch
  const std::uint32_t* ids;   // ray i is rays[ids[i]]
  std::uint32_t size, lanes;  // of rays, and with those that fill the last group
  int kx, ky, kz;             // as in Watertight::RayData
  float origin[3];            // of the first ray
  bool has_one_origin;        // of all rays, in its bits: the sign of a zero may be that of a hit
  float largest_origin;       // of all coordinates, as magnitudes
  float reach = kInfinity;    // of LocatedBounds, where any-hit queries ask for these

  HWY_INLINE const Ray& ray(std::uint32_t i) const { return rays[ids[i]]; }
};

HWY_INLINE float least_lane(Floats v) { return hn::GetLane(hn::MinOfLanes(kFloats, v)); }
HWY_INLINE float most_lane(Floats v) { return hn::GetLane(hn::MaxOfLanes(kFloats, v)); }

// A vector of rays.
struct RayLanes {
  Floats org[3], t_min, dir[3], t_max;
};

// Of as many rays as a vector has lanes: each half of them one after the other in memory.
HWY_INLINE RayLanes load_lanes(const Ray* lower, const Ray* upper) {
  RayLanes r;
#if HWY_TARGET == HWY_SCALAR
  (void)upper;
  const float* const first = &lower->org.x;
  for (int a = 0; a < 3; ++a) r.org[a] = load(first + a), r.dir[a] = load(first + 4 + a);
  r.t_min = load(first + 3), r.t_max = load(first + 7);
#else
  // Origins are even lanes then, and directions odd ones.
  Floats x0, x1, y0, y1, z0, z1, t0, t1;
  hn::LoadInterleaved4(kFloats, &lower->org.x, x0, y0, z0, t0);
  hn::LoadInterleaved4(kFloats, &upper->org.x, x1, y1, z1, t1);
  r.org[0] = hn::ConcatEven(kFloats, x1, x0), r.dir[0] = hn::ConcatOdd(kFloats, x1, x0);
  r.org[1] = hn::ConcatEven(kFloats, y1, y0), r.dir[1] = hn::ConcatOdd(kFloats, y1, y0);
  r.org[2] = hn::ConcatEven(kFloats, z1, z0), r.dir[2] = hn::ConcatOdd(kFloats, z1, z0);
  r.t_min = hn::ConcatEven(kFloats, t1, t0), r.t_max = hn::ConcatOdd(kFloats, t1, t0);
#endif
  return r;
}

// Whether each half of a vector's rays is a run, one after the other in memory.
HWY_INLINE bool are_runs(const std::uint32_t* ids) {
  const std::uint32_t half = (width() + 1) / 2;
  const Words lane = hn::Iota(kWords, 0);
  const Words expected = hn::IfThenElse(hn::Lt(lane, hn::Set(kWords, half)), hn::Set(kWords, ids[0]),
                                        hn::Set(kWords, ids[width() / 2] - width() / 2));
  return hn::AllTrue(kWords, hn::Eq(hn::Sub(hn::LoadU(kWords, ids), lane), expected));
}

// The rays of the next lanes, of which there are `left` more; the last one fills lanes without a ray. Rays that come in runs
// need no copy.
HWY_INLINE RayLanes gather_lanes(const Ray* rays, const std::uint32_t* ids, std::uint32_t left) {
  if (left >= width() && HWY_LIKELY(are_runs(ids))) return load_lanes(rays + ids[0], rays + ids[width() / 2]);
  Ray copies[16];
  for (std::uint32_t i = 0; i < width(); ++i) copies[i] = rays[ids[i < left ? i : left - 1]];
  return load_lanes(copies, copies + width() / 2);
}

// Rays of one face, whose axis it is.
HWY_INLINE void load_rays(const Ray* rays, const std::uint32_t* ids, std::uint32_t size, int axis, Packet& p) {
  p.rays = rays, p.ids = ids, p.size = size, p.lanes = (size + width() - 1) / width() * width();
  p.kz = axis, p.kx = (axis + 1) % 3, p.ky = (axis + 2) % 3;
  for (int a = 0; a < 3; ++a) p.origin[a] = p.ray(0).org[a];
  Words differ = hn::Zero(kWords);
  Floats largest_origin = hn::Zero(kFloats);
  for (std::uint32_t i = 0; i < p.lanes; i += width()) {
    const RayLanes r = gather_lanes(rays, ids + i, size - i);
    for (int a = 0; a < 3; ++a) {
      hn::Store(r.org[a], kFloats, p.org[a] + i), hn::Store(r.dir[a], kFloats, p.dir[a] + i);
      hn::Store(hn::Div(set(1), r.dir[a]), kFloats, p.inv[a] + i);
      largest_origin = most(hn::Abs(r.org[a]), largest_origin);
      differ = hn::Or(differ, hn::Xor(hn::BitCast(kWords, r.org[a]), hn::BitCast(kWords, set(p.origin[a]))));
    }
    hn::Store(hn::Div(load(p.dir[p.kx] + i), load(p.dir[p.kz] + i)), kFloats, p.shear[0] + i);
    hn::Store(hn::Div(load(p.dir[p.ky] + i), load(p.dir[p.kz] + i)), kFloats, p.shear[1] + i);
    hn::Store(most(r.t_min, set(0)), kFloats, p.t_min + i);
    hn::Store(least(r.t_max, set(std::numeric_limits<float>::max())), kFloats, p.t + i);
    hn::Store(hn::Set(kWords, kNoHit), kWords, p.prim_id + i);
    hn::Store(set(0), kFloats, p.u + i), hn::Store(set(0), kFloats, p.v + i);
  }
  p.has_one_origin = hn::AllTrue(kWords, hn::Eq(differ, hn::Zero(kWords)));
  p.largest_origin = most_lane(largest_origin);
  for (std::uint32_t i = size; i < p.lanes; ++i) p.t_min[i] = kInfinity, p.t[i] = -kInfinity;
}

// The answer to ray r.
HWY_INLINE void store_answer(const Packet& p, std::uint32_t r, Hit& answer) {
  answer = p.prim_id[r] == kNoHit ? Hit{} : Hit{p.t[r], p.u[r], p.v[r], p.prim_id[r]};
}
HWY_INLINE void store_answer(const Packet& p, std::uint32_t r, std::uint8_t& answer) {
  answer = p.prim_id[r] == kNoHit ? 0 : 1;
}

// The answers to the rays of a vector, each half of them one after the other in memory.
HWY_INLINE void store_lanes(const Packet& p, std::uint32_t first, Hit* lower, Hit* upper) {
#if HWY_TARGET == HWY_SCALAR
  (void)upper;
  store_answer(p, first, *lower);
#else
  const hn::Half<decltype(kFloats)> half;
  const Words prim_id = hn::Load(kWords, p.prim_id + first);
  const Mask is_miss = hn::RebindMask(kFloats, hn::Eq(prim_id, hn::Set(kWords, kNoHit)));
  const Floats t = hn::IfThenElse(is_miss, set(Hit{}.t), load(p.t + first)), id = hn::BitCast(kFloats, prim_id);
  const Floats u = load(p.u + first), v = load(p.v + first);
  hn::StoreInterleaved4(hn::LowerHalf(half, t), hn::LowerHalf(half, u), hn::LowerHalf(half, v), hn::LowerHalf(half, id), half,
                        &lower->t);
  hn::StoreInterleaved4(hn::UpperHalf(half, t), hn::UpperHalf(half, u), hn::UpperHalf(half, v), hn::UpperHalf(half, id), half,
                        &upper->t);
#endif
}

// answers[ids[r]] answers ray r.
HWY_INLINE void store_answers(const Packet& p, Hit* answers) {
  for (std::uint32_t first = 0; first < p.size; first += width()) {
    const std::uint32_t end = std::min(first + width(), p.size), *const ids = p.ids + first;
    if (end - first == width() && HWY_LIKELY(are_runs(ids)))
      store_lanes(p, first, answers + ids[0], answers + ids[width() / 2]);
    else
      for (std::uint32_t r = first; r < end; ++r) store_answer(p, r, answers[p.ids[r]]);
  }
}
HWY_INLINE void store_answers(const Packet& p, std::uint8_t* occluded) {
  for (std::uint32_t r = 0; r < p.size; ++r) store_answer(p, r, occluded[p.ids[r]]);
}

// Where the coordinate kx (side 0) or ky (side 1) of the rays from lane i on is at a plane of the axis kz.
HWY_INLINE Floats at_plane(const Packet& p, std::uint32_t i, int side, float plane) {
  const float* const org = p.org[side == 0 ? p.kx : p.ky];
  return hn::Add(load(org + i), hn::Mul(load(p.shear[side] + i), hn::Sub(set(plane), load(p.org[p.kz] + i))));
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace accel
HWY_AFTER_NAMESPACE();

#endif
