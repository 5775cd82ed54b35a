#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "libaccel/packet/ray_hash_simd.cpp"
#include <hwy/foreach_target.h>
// Above all other headers.
#include <hwy/highway.h>

#include <algorithm>

#include "libaccel/packet/packet_simd-inl.h"
#include "libaccel/packet/ray_hash_simd.h"

HWY_BEFORE_NAMESPACE();
namespace accel {
namespace HWY_NAMESPACE {
namespace {

const hn::Half<decltype(kWords)> kHalfWords;
const hn::Repartition<std::uint64_t, decltype(kWords)> kCodes;
using Codes = decltype(hn::Zero(kCodes));

// A coordinate in cells, as a number of a cell from 0 to `last`; NaN is in the first one.
HWY_INLINE Words cell_at(Floats cell, float last) {
  const hn::RebindToSigned<decltype(kWords)> ints;
  const Floats inside = hn::IfThenElse(hn::Lt(cell, set(last)), cell, set(last));
  return hn::BitCast(kWords, hn::ConvertTo(ints, hn::IfThenElseZero(hn::Gt(cell, set(0)), inside)));
}

template <int kShift>
HWY_INLINE Codes spread(Codes x, std::uint64_t mask) {
  return hn::And(hn::Or(x, hn::ShiftLeft<kShift>(x)), hn::Set(kCodes, mask));
}
// spread_2() and spread_3() of core/morton.h, of 12 bits.
HWY_INLINE Codes spread_2(Codes x) {
  x = spread<4>(spread<8>(x, 0x00ff00ff00ff00ffull), 0x0f0f0f0f0f0f0f0full);
  return spread<1>(spread<2>(x, 0x3333333333333333ull), 0x5555555555555555ull);
}
HWY_INLINE Codes spread_3(Codes x) {
  x = spread<8>(spread<16>(x, 0x001f0000ff0000ffull), 0x100f00f00f00f00full);
  return spread<2>(spread<4>(x, 0x10c30c30c30c30c3ull), 0x1249249249249249ull);
}

// What the values are made of.
struct Cells {
  Words origin[3], face, within[2];
};

HWY_INLINE Cells cells_of(const FineRayHash& hash, const RayLanes& r) {
  constexpr float kLastOfOrigins = static_cast<float>((1 << FineRayHash::kOriginBits) - 1);
  constexpr float kDirections = static_cast<float>(1 << FineRayHash::kDirectionBits);
  Cells cells;
  Floats size[3];
  for (int a = 0; a < 3; ++a) {
    cells.origin[a] = cell_at(hn::Mul(hn::Sub(r.org[a], set(hash.lo[a])), set(hash.cells)), kLastOfOrigins);
    size[a] = hn::Abs(r.dir[a]);
  }
  const Mask is_x = hn::And(hn::Ge(size[0], size[1]), hn::Ge(size[0], size[2]));
  const Mask is_y = hn::AndNot(is_x, hn::Ge(size[1], size[2]));
  const Floats along = hn::IfThenElse(is_x, r.dir[0], hn::IfThenElse(is_y, r.dir[1], r.dir[2]));
  const Words axis = hn::IfThenElse(hn::RebindMask(kWords, is_x), hn::Set(kWords, 0),
                                    hn::IfThenElse(hn::RebindMask(kWords, is_y), hn::Set(kWords, 2), hn::Set(kWords, 4)));
  const Mask is_negative = hn::Lt(along, set(0));
  cells.face = hn::Or(axis, hn::IfThenElseZero(hn::RebindMask(kWords, is_negative), hn::Set(kWords, 1)));
  const Floats scale = hn::Div(set(1), hn::IfThenElse(is_negative, hn::Neg(along), along));
  const Floats first = hn::IfThenElse(is_x, r.dir[1], r.dir[0]);
  const Floats second = hn::IfThenElse(hn::Or(is_x, is_y), r.dir[2], r.dir[1]);
  const auto on_face = [&](Floats x) HWY_ATTR {
    return cell_at(hn::Mul(hn::Add(hn::Mul(x, scale), set(1)), set(kDirections / 2)), kDirections - 1);
  };
  cells.within[0] = on_face(first), cells.within[1] = on_face(second);
  return cells;
}

// Of half the lanes; `half` takes them as codes.
template <class Half>
HWY_INLINE Codes value_of(const Cells& cells, const Half& half) {
  const Codes cell = hn::Or(hn::Or(spread_3(half(cells.origin[0])), hn::ShiftLeft<1>(spread_3(half(cells.origin[1])))),
                            hn::ShiftLeft<2>(spread_3(half(cells.origin[2]))));
  const Codes within = hn::Or(spread_2(half(cells.within[0])), hn::ShiftLeft<1>(spread_2(half(cells.within[1]))));
  return hn::Or(hn::ShiftLeft<2 * FineRayHash::kDirectionBits>(hn::Or(hn::ShiftLeft<3>(cell), half(cells.face))), within);
}

void hash_rays(const FineRayHash& hash, const Ray* rays, const std::uint32_t* ids, std::size_t count, std::uint64_t* values) {
#if HWY_TARGET == HWY_SCALAR
  for (std::size_t i = 0; i < count; ++i) values[i] = hash(rays[ids[i]]);
#else
  const std::size_t width = hn::Lanes(kFloats);
  for (std::size_t i = 0; i < count; i += width) {
    const std::size_t left = std::min(count - i, width);
    const Cells cells = cells_of(hash, gather_lanes(rays, ids + i, static_cast<std::uint32_t>(left)));
    alignas(64) std::uint64_t found[16];
    hn::Store(value_of(cells, [](Words w) HWY_ATTR { return hn::PromoteTo(kCodes, hn::LowerHalf(kHalfWords, w)); }), kCodes,
              found);
    hn::Store(value_of(cells, [](Words w) HWY_ATTR { return hn::PromoteTo(kCodes, hn::UpperHalf(kHalfWords, w)); }), kCodes,
              found + width / 2);
    std::copy_n(found, left, values + i);
  }
#endif
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace accel
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace accel {
HWY_EXPORT(hash_rays);

void hash_rays_simd(const FineRayHash& hash, const Ray* rays, const std::uint32_t* ids, std::size_t count,
                    std::uint64_t* values) {
  HWY_DYNAMIC_DISPATCH(hash_rays)(hash, rays, ids, count, values);
}
}  // namespace accel
#endif
