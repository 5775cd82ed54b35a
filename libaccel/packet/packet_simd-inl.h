// The rays of a packet in SIMD lanes. The guard lets the header through once for each target that Highway compiles.
#if defined(ACCEL_PACKET_SIMD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ACCEL_PACKET_SIMD_INL_H
#undef ACCEL_PACKET_SIMD_INL_H
#else
#define ACCEL_PACKET_SIMD_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>

#include "libaccel/core/least_simd-inl.h"
#include "libaccel/packet/frustum.h"
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

  const std::uint32_t* ids;   // of the rays in the batch
  std::uint32_t size, lanes;  // of rays, and with those that fill the last group
  int kx, ky, kz;             // as in Watertight::RayData
  float origin[3];            // of the first ray
  bool has_one_origin;        // of all rays, in its bits: the sign of a zero may be that of a hit
  float largest_origin;       // of all coordinates, as magnitudes
  float reach = kInfinity;    // of LocatedBounds, where any-hit queries ask for these

  // The interval that is left.
  HWY_INLINE Ray ray(std::uint32_t i) const {
    return {{org[0][i], org[1][i], org[2][i]}, t_min[i], {dir[0][i], dir[1][i], dir[2][i]}, t[i]};
  }
};

HWY_INLINE float least_lane(Floats v) { return hn::GetLane(hn::MinOfLanes(kFloats, v)); }
HWY_INLINE float most_lane(Floats v) { return hn::GetLane(hn::MaxOfLanes(kFloats, v)); }

// A vector of rays.
struct RayLanes {
  Floats org[3], t_min, dir[3], t_max;
};

#if HWY_TARGET != HWY_SCALAR
// Vector k of the eight that as many rays as there are lanes fill one after the other, of which ray_at(i) is number i.
template <class RayAt>
HWY_INLINE Floats load_eighth(std::uint32_t k, const RayAt& ray_at) {
  constexpr std::uint32_t kLanes = static_cast<std::uint32_t>(hn::MaxLanes(kFloats));
  if constexpr (kLanes == 16) {
    const hn::Half<decltype(kFloats)> half;
    return hn::Combine(kFloats, hn::LoadU(half, &ray_at(2 * k + 1).org.x), hn::LoadU(half, &ray_at(2 * k).org.x));
  } else {
    return hn::LoadU(kFloats, &ray_at(k * kLanes / 8).org.x + k * kLanes % 8);
  }
}
#endif

// As many rays as a vector has lanes, of which ray_at(i) is number i.
template <class RayAt>
HWY_INLINE RayLanes load_lanes(const RayAt& ray_at) {
  static_assert(sizeof(Ray) == 8 * sizeof(float));
  RayLanes r;
#if HWY_TARGET == HWY_SCALAR
  const float* const first = &ray_at(0).org.x;
  for (int a = 0; a < 3; ++a) r.org[a] = load(first + a), r.dir[a] = load(first + 4 + a);
  r.t_min = load(first + 3), r.t_max = load(first + 7);
#else
  // Deals the floats by the lowest bit of their place in a ray, three times.
  Floats by_none[8], by_one[8], by_two[8];
  for (std::uint32_t k = 0; k < 8; ++k) by_none[k] = load_eighth(k, ray_at);
  const auto deal = [](const Floats* from, Floats* even, Floats* odd, int count) HWY_ATTR {
    for (int k = 0; k < count; ++k) {
      even[k] = hn::ConcatEven(kFloats, from[2 * k + 1], from[2 * k]);
      odd[k] = hn::ConcatOdd(kFloats, from[2 * k + 1], from[2 * k]);
    }
  };
  deal(by_none, by_one, by_one + 4, 4);
  for (int i = 0; i < 8; i += 4) deal(by_one + i, by_two + i, by_two + i + 2, 2);
  // By bits now: org.x, dir.x; org.z, dir.z; org.y, dir.y; t_min, t_max.
  Floats* const values[] = {r.org, r.dir, r.org + 2, r.dir + 2, r.org + 1, r.dir + 1, &r.t_min, &r.t_max};
  for (int i = 0; i < 8; i += 2) deal(by_two + i, values[i], values[i + 1], 1);
#endif
  return r;
}

// The rays of the next lanes, of which there are `left` more; the last one fills lanes without a ray.
HWY_INLINE RayLanes gather_lanes(const Ray* rays, const std::uint32_t* ids, std::uint32_t left) {
  std::uint32_t filled[16];
  if (HWY_UNLIKELY(left < width())) {
    for (std::uint32_t i = 0; i < width(); ++i) filled[i] = ids[std::min(i, left - 1)];
    ids = filled;
  }
  return load_lanes([&](std::uint32_t i) -> const Ray& { return rays[ids[i]]; });
}

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

// Rays of one face, whose axis it is; lanes_at(i) are those from lane i on, and in lanes without a ray any one of them.
template <class LanesAt>
HWY_INLINE void fill_packet(std::uint32_t size, int axis, Packet& p, const LanesAt& lanes_at) {
  p.size = size, p.lanes = (size + width() - 1) / width() * width();
  p.kz = axis, p.kx = (axis + 1) % 3, p.ky = (axis + 2) % 3;
  Words differ = hn::Zero(kWords);
  Floats largest_origin = hn::Zero(kFloats);
  for (std::uint32_t i = 0; i < p.lanes; i += width()) {
    const RayLanes r = lanes_at(i);
    for (int a = 0; a < 3; ++a) {
      if (i == 0) p.origin[a] = hn::GetLane(r.org[a]);
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

// Those with these ids.
HWY_INLINE void load_rays(const Ray* rays, const std::uint32_t* ids, std::uint32_t size, int axis, Packet& p) {
  p.ids = ids;
  fill_packet(size, axis, p, [=](std::uint32_t i) HWY_ATTR { return gather_lanes(rays, ids + i, size - i); });
}

// The answer to ray r.
HWY_INLINE void store_answer(const Packet& p, std::uint32_t r, Hit& answer) {
  answer = p.prim_id[r] == kNoHit ? Hit{} : Hit{p.t[r], p.u[r], p.v[r], p.prim_id[r]};
}
HWY_INLINE void store_answer(const Packet& p, std::uint32_t r, std::uint8_t& answer) {
  answer = p.prim_id[r] == kNoHit ? 0 : 1;
}

// The answers to a vector of rays.
HWY_INLINE void answers_of(const Packet& p, std::uint32_t first, Hit* answers) {
  const Words prim_id = hn::Load(kWords, p.prim_id + first);
  const Mask is_miss = hn::RebindMask(kFloats, hn::Eq(prim_id, hn::Set(kWords, kNoHit)));
  const Floats t = hn::IfThenElse(is_miss, set(Hit{}.t), load(p.t + first));
  hn::StoreInterleaved4(t, load(p.u + first), load(p.v + first), hn::BitCast(kFloats, prim_id), kFloats, &answers[0].t);
}
HWY_INLINE void answers_of(const Packet& p, std::uint32_t first, std::uint8_t* answers) {
  const hn::Rebind<std::int32_t, decltype(kFloats)> ints;
  const hn::Rebind<std::uint8_t, decltype(kFloats)> bytes;
  const auto is_miss = hn::Eq(hn::Load(kWords, p.prim_id + first), hn::Set(kWords, kNoHit));
  const Words answer = hn::IfThenElse(is_miss, hn::Zero(kWords), hn::Set(kWords, 1));
  hn::StoreU(hn::DemoteTo(bytes, hn::BitCast(ints, answer)), bytes, answers);
}

// answers[ids[r]] answers ray r. Rays of pictures come in runs of four at least.
template <class Answer>
HWY_INLINE void store_answers(const Packet& p, Answer* answers) {
  std::uint32_t r = 0;
#if HWY_TARGET != HWY_SCALAR
  constexpr std::uint32_t kLanes = static_cast<std::uint32_t>(hn::MaxLanes(kFloats)), kRun = 4;
  const Words place = hn::And(hn::Iota(kWords, 0), hn::Set(kWords, kRun - 1));
  for (; r + kLanes <= p.size; r += kLanes) {
    alignas(64) Answer some[kLanes];
    answers_of(p, r, some);
    const std::uint32_t* const ids = p.ids + r;
    const Words id = hn::LoadU(kWords, ids);
    if (HWY_LIKELY(hn::AllTrue(kWords, hn::Eq(id, hn::Add(hn::Broadcast<0>(id), place)))))
      for (std::uint32_t i = 0; i < kLanes; i += kRun) std::memcpy(answers + ids[i], some + i, kRun * sizeof(Answer));
    else
      for (std::uint32_t i = 0; i < kLanes; ++i) answers[ids[i]] = some[i];
  }
#endif
  for (; r < p.size; ++r) store_answer(p, r, answers[p.ids[r]]);
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
