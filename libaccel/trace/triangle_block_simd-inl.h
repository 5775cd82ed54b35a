// A ray against a block of four triangles (structure/triangle_block.h) with the watertight test: the operations of
// geometry/watertight.h in SIMD lanes, hence its hits, bit for bit. The guard lets the header through once for each target that
// Highway compiles.
#if defined(ACCEL_TRIANGLE_BLOCK_SIMD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ACCEL_TRIANGLE_BLOCK_SIMD_INL_H
#undef ACCEL_TRIANGLE_BLOCK_SIMD_INL_H
#else
#define ACCEL_TRIANGLE_BLOCK_SIMD_INL_H
#endif

#include <hwy/highway.h>

#include <bit>
#include <cstdint>

#include "libaccel/core/least_simd-inl.h"
#include "libaccel/geometry/watertight.h"
#include "libaccel/structure/triangle_block.h"
#include "libaccel/trace/traverser.h"

HWY_BEFORE_NAMESPACE();
namespace accel {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
const hn::CappedTag<float, kBlockLanes> kTriangles;
const hn::CappedTag<double, kBlockLanes> kDoubles;
const hn::Rebind<float, decltype(kDoubles)> kHalves;
using Triangles = decltype(hn::Zero(kTriangles));
using Doubles = decltype(hn::Zero(kDoubles));

template <class D, class M>
HWY_INLINE std::uint32_t bits_of(D d, M mask) {
  std::uint8_t bits[8] = {};
  hn::StoreMaskBits(d, mask, bits);
  return bits[0];
}

// Watertight::prepare() without branches: which axis is the longest nobody can predict.
HWY_INLINE Watertight::RayData prepare_watertight(const Ray& ray) {
  const float *const org = &ray.org.x, *const dir = &ray.dir.x;
  const float x = dir[0] < 0 ? -dir[0] : dir[0], y = dir[1] < 0 ? -dir[1] : dir[1], z = dir[2] < 0 ? -dir[2] : dir[2];
  const unsigned not_x = (x >= y ? 0u : 1u) | (x >= z ? 0u : 1u), kz = not_x + (not_x & (y >= z ? 0u : 1u));
  constexpr std::uint8_t kNext[5] = {0, 1, 2, 0, 1};
  const int kx = kNext[kz + 1], ky = kNext[kz + 2];
  const float dir_z = dir[kz];
  return {kx, ky, static_cast<int>(kz), org[kx], org[ky], org[kz], dir[kx] / dir_z, dir[ky] / dir_z, dir_z};
}

// Triangles as the ray sees them: Watertight::Projection.
struct Projected {
  Triangles z[3], edge[3];
};

// Watertight::project() of the triangles of a block from lane `first` on, as far as it decides: which may be hit.
HWY_INLINE std::uint32_t project(const TriangleBlock& block, const Watertight::RayData& ray, std::size_t first, Projected& p) {
  const auto set = [](float v) HWY_ATTR { return hn::Set(kTriangles, v); };
  const auto load = [=](const float* from) HWY_ATTR { return hn::Load(kTriangles, from + first); };
  const auto &vx = block.vertex[ray.kx], &vy = block.vertex[ray.ky], &vz = block.vertex[ray.kz];
  Triangles x[3], y[3];
  for (int i = 0; i < 3; ++i) {
    p.z[i] = hn::Sub(load(vz[i]), set(ray.org_z));
    x[i] = hn::Sub(hn::Sub(load(vx[i]), set(ray.org_x)), hn::Mul(set(ray.shear_x), p.z[i]));
    y[i] = hn::Sub(hn::Sub(load(vy[i]), set(ray.org_y)), hn::Mul(set(ray.shear_y), p.z[i]));
  }
  Triangles* const e = p.edge;
  e[0] = hn::Sub(hn::Mul(x[2], y[1]), hn::Mul(y[2], x[1]));
  e[1] = hn::Sub(hn::Mul(x[0], y[2]), hn::Mul(y[0], x[2]));
  e[2] = hn::Sub(hn::Mul(x[1], y[0]), hn::Mul(y[1], x[0]));
  // Where one is NaN, all are: the lane is empty.
  const Triangles lowest = least(least(e[0], e[1]), e[2]), highest = most(most(e[0], e[1]), e[2]), zero = hn::Zero(kTriangles);
  return bits_of(kTriangles, hn::Or(hn::Ge(lowest, zero), hn::Le(highest, zero)));
}

// Of the vertices that are nearest to the origin: Watertight::nearest_vertex().
HWY_INLINE void nearest_vertices(const TriangleBlock& block, const Vec3& org, std::size_t first, Triangles nearest[3]) {
  Triangles v[3][3], d[3];
  for (int i = 0; i < 3; ++i) {
    for (int a = 0; a < 3; ++a) v[i][a] = hn::Load(kTriangles, block.vertex[a][i] + first);
    const auto size = [&](int a) HWY_ATTR { return hn::Abs(hn::Sub(v[i][a], hn::Set(kTriangles, org[a]))); };
    d[i] = most(most(size(0), size(1)), size(2));
  }
  const auto second = hn::Lt(d[1], d[0]), third = hn::Lt(d[2], least(d[1], d[0]));
  for (int a = 0; a < 3; ++a) nearest[a] = hn::IfThenElse(third, v[2][a], hn::IfThenElse(second, v[1][a], v[0][a]));
}

// What Watertight::locate() finds for each lane of a block.
struct alignas(32) Located {
  float t[kBlockLanes], u[kBlockLanes], v[kBlockLanes];
  std::uint32_t is_exact;  // bits: whether t is the plane's distance; otherwise it is not set
};

// Lanes of double precision, which may be fewer: those from `part` on.
HWY_INLINE Doubles promote(const float* from) { return hn::PromoteTo(kDoubles, hn::Load(kHalves, from)); }

// Watertight::plane_distance() and whether it lies between the vertices.
HWY_INLINE void locate_part(const TriangleBlock& block, const Ray& ray, float dir_z, const Located bounds[2],
                            const float nearest[3][kBlockLanes], std::size_t part, Located& located) {
  const auto set = [](float v) HWY_ATTR { return hn::Set(kDoubles, static_cast<double>(v)); };
  Doubles e1[3], e2[3];
  for (int a = 0; a < 3; ++a) {
    const Doubles v0 = promote(block.vertex[a][0] + part);
    e1[a] = hn::Sub(promote(block.vertex[a][1] + part), v0), e2[a] = hn::Sub(promote(block.vertex[a][2] + part), v0);
  }
  Doubles above, below;
  for (int a = 0; a < 3; ++a) {
    const int b = a == 2 ? 0 : a + 1, c = a == 0 ? 2 : a - 1;
    const Doubles n = hn::Sub(hn::Mul(e1[b], e2[c]), hn::Mul(e1[c], e2[b]));
    const Doubles s = hn::Mul(n, hn::Sub(promote(nearest[a] + part), set(ray.org[a]))), d = hn::Mul(n, set(ray.dir[a]));
    above = a == 0 ? s : hn::Add(above, s), below = a == 0 ? d : hn::Add(below, d);
  }
  const Doubles t = hn::Div(above, below), depth = hn::Mul(t, set(dir_z));
  const auto within = hn::And(hn::Ge(depth, promote(bounds[0].t + part)), hn::Le(depth, promote(bounds[1].t + part)));
  hn::Store(hn::DemoteTo(kHalves, t), kHalves, located.t + part);
  located.is_exact |= bits_of(kDoubles, within) << part;
}

HWY_INLINE void locate(const TriangleBlock& block, const Ray& ray, float dir_z, std::size_t first, const Projected& p,
                       Located& located) {
  const Triangles det = hn::Add(hn::Add(p.edge[0], p.edge[1]), p.edge[2]);
  hn::Store(hn::Div(p.edge[1], det), kTriangles, located.u + first);
  hn::Store(hn::Div(p.edge[2], det), kTriangles, located.v + first);

  const Triangles lowest = least(least(p.z[0], p.z[1]), p.z[2]), highest = most(most(p.z[0], p.z[1]), p.z[2]);
  const Triangles rounding = hn::Set(kTriangles, kUnitRoundoff * 2);
  Located bounds[2];
  hn::Store(hn::Sub(lowest, hn::Mul(rounding, hn::Abs(lowest))), kTriangles, bounds[0].t + first);
  hn::Store(hn::Add(highest, hn::Mul(rounding, hn::Abs(highest))), kTriangles, bounds[1].t + first);
  Triangles vertices[3];
  nearest_vertices(block, ray.org, first, vertices);
  alignas(32) float nearest[3][kBlockLanes];
  for (int a = 0; a < 3; ++a) hn::Store(vertices[a], kTriangles, nearest[a] + first);
  for (std::size_t part = first; part < first + hn::Lanes(kTriangles); part += hn::Lanes(kDoubles))
    locate_part(block, ray, dir_z, bounds, nearest, part, located);
}

// Takes the candidates of a block, in the order of lanes. Lanes with an edge function that is zero, and without an exact
// distance, are tested by the scalar test. Returns whether an any-hit query has its answer.
template <Query kQuery>
HWY_INLINE bool accept_candidates(const TriangleBlock& block, const Ray& ray, const Watertight::RayData& data, float t_min,
                                  std::uint32_t candidates, std::uint32_t on_edge, const Located& located, Hit& hit) {
  const std::uint32_t simple = located.is_exact & ~on_edge;
  for (; candidates != 0; candidates &= candidates - 1) {
    const auto lane = static_cast<std::uint32_t>(std::countr_zero(candidates));
    Hit candidate{located.t[lane], located.u[lane], located.v[lane], kNoHit};
    if (HWY_UNLIKELY((simple >> lane & 1u) == 0) && !Watertight::intersect(block.packed(lane), ray, data, candidate)) continue;
    candidate.prim_id = block.prim_id[lane];
    if (accept_hit(candidate, t_min, hit) && kQuery == Query::any) return true;
  }
  return false;
}

template <Query kQuery>
HWY_INLINE bool intersect_block(const TriangleBlock& block, const Ray& ray, const Watertight::RayData& data, float t_min,
                                Hit& hit) {
  Located located;
  located.is_exact = 0;
  std::uint32_t candidates = 0, on_edge = 0;
  for (std::size_t first = 0; first < kBlockLanes; first += hn::Lanes(kTriangles)) {
    Projected p;
    const std::uint32_t inside = project(block, data, first, p);
    if (HWY_LIKELY(inside == 0)) continue;
    const auto is_zero = [&](int i) HWY_ATTR { return hn::Eq(p.edge[i], hn::Zero(kTriangles)); };
    on_edge |= bits_of(kTriangles, hn::Or(hn::Or(is_zero(0), is_zero(1)), is_zero(2))) << first;
    candidates |= inside << first;
    locate(block, ray, data.dir_z, first, p, located);
  }
  if (HWY_LIKELY(candidates == 0)) return false;
  return accept_candidates<kQuery>(block, ray, data, t_min, candidates, on_edge, located, hit);
}

// A triangle test as traversal uses it: of the rays that are traced, and of a block.
template <class Test>
struct BlockTest;

template <>
struct BlockTest<Watertight> {
  static HWY_INLINE Watertight::RayData prepare(const Ray& ray) { return prepare_watertight(ray); }
  template <Query kQuery>
  static HWY_INLINE bool intersect(const TriangleBlock& block, const Ray& ray, const Watertight::RayData& data, float t_min,
                                   Hit& hit) {
    return intersect_block<kQuery>(block, ray, data, t_min, hit);
  }
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace accel
HWY_AFTER_NAMESPACE();

#endif
