// A ray against a block of four triangles (structure/triangle_block.h) with the tests that are there to be compared with the
// watertight one: the operations of geometry/moeller_trumbore.h, woop.h and pluecker.h in SIMD lanes, hence their hits, bit for
// bit (where fused operations are none of the target's, not those of WoopKahan). The guard lets the header through once for
// each target that Highway compiles.
#if defined(ACCEL_TRIANGLE_BLOCK_TESTS_SIMD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ACCEL_TRIANGLE_BLOCK_TESTS_SIMD_INL_H
#undef ACCEL_TRIANGLE_BLOCK_TESTS_SIMD_INL_H
#else
#define ACCEL_TRIANGLE_BLOCK_TESTS_SIMD_INL_H
#endif

#include <hwy/highway.h>

#include "libaccel/geometry/moeller_trumbore.h"
#include "libaccel/geometry/pluecker.h"
#include "libaccel/geometry/woop.h"
#include "libaccel/trace/triangle_block_simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace accel {
namespace HWY_NAMESPACE {
namespace {

// Vectors of space, one a lane.
struct Vectors {
  Triangles x, y, z;
};

HWY_INLINE Vectors all_of(Vec3 v) { return {hn::Set(kTriangles, v.x), hn::Set(kTriangles, v.y), hn::Set(kTriangles, v.z)}; }
HWY_INLINE Vectors vertices_of(const TriangleBlock& block, int i, std::size_t first) {
  return {hn::Load(kTriangles, block.vertex[0][i] + first), hn::Load(kTriangles, block.vertex[1][i] + first),
          hn::Load(kTriangles, block.vertex[2][i] + first)};
}
HWY_INLINE Vectors sum(Vectors a, Vectors b) { return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)}; }
HWY_INLINE Vectors difference(Vectors a, Vectors b) { return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)}; }
HWY_INLINE Vectors magnitudes(Vectors a) { return {hn::Abs(a.x), hn::Abs(a.y), hn::Abs(a.z)}; }
HWY_INLINE Triangles dot(Vectors a, Vectors b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}
HWY_INLINE Vectors cross(Vectors a, Vectors b) {
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)), hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}

// What a test finds in lanes: who is hit, and where.
struct Candidates {
  std::uint32_t lanes = 0;
  alignas(32) float t[kBlockLanes], u[kBlockLanes], v[kBlockLanes];

  HWY_INLINE void store(std::size_t first, std::uint32_t hit, Triangles at_t, Triangles at_u, Triangles at_v) {
    lanes |= hit << first;
    hn::Store(at_t, kTriangles, t + first), hn::Store(at_u, kTriangles, u + first), hn::Store(at_v, kTriangles, v + first);
  }
};

// What all of these tests do with a block. Lanes<Test>::find() tests the triangles from lane `first` on.
template <class Test>
struct Lanes;

template <class Test>
struct BlockTestInLanes {
  static HWY_INLINE typename Test::RayData prepare(const Ray& ray) { return Test::prepare(ray); }
  template <Query kQuery>
  static HWY_INLINE bool intersect(const TriangleBlock& block, const Ray& ray, const typename Test::RayData& data, float t_min,
                                   Hit& hit) {
    Candidates found;
    for (std::size_t first = 0; first < kBlockLanes; first += hn::Lanes(kTriangles))
      Lanes<Test>::find(block, ray, data, first, found);
    for (; HWY_UNLIKELY(found.lanes != 0); found.lanes &= found.lanes - 1) {
      const auto lane = static_cast<std::uint32_t>(std::countr_zero(found.lanes));
      const Hit candidate{found.t[lane], found.u[lane], found.v[lane], block.prim_id[lane]};
      if (accept_hit(candidate, t_min, hit) && kQuery == Query::any) return true;
    }
    return false;
  }
};

template <>
struct BlockTest<MoellerTrumbore> : BlockTestInLanes<MoellerTrumbore> {};
template <>
struct BlockTest<Woop> : BlockTestInLanes<Woop> {};
template <>
struct BlockTest<WoopKahan> : BlockTestInLanes<WoopKahan> {};
template <>
struct BlockTest<Pluecker> : BlockTestInLanes<Pluecker> {};

template <>
struct Lanes<MoellerTrumbore> {
  static HWY_INLINE void find(const TriangleBlock& block, const Ray& ray, MoellerTrumbore::RayData, std::size_t first,
                              Candidates& found) {
    const Triangles zero = hn::Zero(kTriangles), one = hn::Set(kTriangles, 1.0f);
    const Vectors v0 = vertices_of(block, 0, first), dir = all_of(ray.dir);
    const Vectors e1 = difference(vertices_of(block, 1, first), v0), e2 = difference(vertices_of(block, 2, first), v0);
    const Vectors p = cross(dir, e2);
    const Triangles det = dot(e1, p), inv_det = hn::Div(one, det);

    const Vectors s = difference(all_of(ray.org), v0);
    const Triangles u = hn::Mul(dot(s, p), inv_det);
    auto inside = hn::And(hn::And(hn::Ge(u, zero), hn::Le(u, one)), hn::Ne(det, zero));
    const Vectors q = cross(s, e1);
    const Triangles v = hn::Mul(dot(dir, q), inv_det);
    inside = hn::And(inside, hn::And(hn::Ge(v, zero), hn::Le(hn::Add(u, v), one)));
    const std::uint32_t hit = bits_of(kTriangles, inside);
    if (HWY_UNLIKELY(hit != 0)) found.store(first, hit, hn::Mul(dot(e2, q), inv_det), u, v);
  }
};

HWY_INLINE Triangles difference_of_products(RoundedProducts, Triangles a, Triangles b, Triangles c, Triangles d) {
  return hn::Sub(hn::Mul(a, b), hn::Mul(c, d));
}
HWY_INLINE Triangles difference_of_products(KahanProducts, Triangles a, Triangles b, Triangles c, Triangles d) {
  const Triangles cd = hn::Mul(c, d);
  return hn::Add(hn::MulSub(a, b, cd), hn::NegMulAdd(c, d, cd));
}

template <class Products>
struct Lanes<WoopTest<Products>> {
  static HWY_INLINE void find(const TriangleBlock& block, const Ray&, const Watertight::RayData& ray, std::size_t first,
                              Candidates& found) {
    const auto set = [](float v) HWY_ATTR { return hn::Set(kTriangles, v); };
    const auto load = [=](const float* from) HWY_ATTR { return hn::Load(kTriangles, from + first); };
    const auto &vx = block.vertex[ray.kx], &vy = block.vertex[ray.ky], &vz = block.vertex[ray.kz];
    Triangles x[3], y[3], z[3];
    for (int i = 0; i < 3; ++i) {
      z[i] = hn::Sub(load(vz[i]), set(ray.org_z));
      x[i] = hn::Sub(hn::Sub(load(vx[i]), set(ray.org_x)), hn::Mul(set(ray.shear_x), z[i]));
      y[i] = hn::Sub(hn::Sub(load(vy[i]), set(ray.org_y)), hn::Mul(set(ray.shear_y), z[i]));
    }
    const Triangles e0 = difference_of_products(Products{}, x[2], y[1], y[2], x[1]);
    const Triangles e1 = difference_of_products(Products{}, x[0], y[2], y[0], x[2]);
    const Triangles e2 = difference_of_products(Products{}, x[1], y[0], y[1], x[0]);
    const Triangles zero = hn::Zero(kTriangles), det = hn::Add(hn::Add(e0, e1), e2);
    const auto front = hn::And(hn::And(hn::Ge(e0, zero), hn::Ge(e1, zero)), hn::Ge(e2, zero));
    const auto back = hn::And(hn::And(hn::Le(e0, zero), hn::Le(e1, zero)), hn::Le(e2, zero));
    const std::uint32_t hit = bits_of(kTriangles, hn::And(hn::Or(front, back), hn::Ne(det, zero)));
    if (HWY_LIKELY(hit == 0)) return;
    const Triangles b0 = hn::Div(e0, det), u = hn::Div(e1, det), v = hn::Div(e2, det);
    const Triangles depth = hn::Add(hn::Add(hn::Mul(b0, z[0]), hn::Mul(u, z[1])), hn::Mul(v, z[2]));
    found.store(first, hit, hn::Div(depth, set(ray.dir_z)), u, v);
  }
};

template <>
struct Lanes<Pluecker> {
  struct Volumes {
    Triangles value, error;
  };

  static HWY_INLINE Volumes volumes_of(Vectors p, Vectors q, Vectors dir, Vectors dir_size) {
    const Vectors edge = difference(q, p), twice_middle = sum(q, p), e = magnitudes(edge), s = magnitudes(twice_middle);
    const auto both = [](Triangles a, Triangles b, Triangles c, Triangles d)
                          HWY_ATTR { return hn::Add(hn::Mul(a, b), hn::Mul(c, d)); };
    const Vectors permanent{both(e.y, s.z, e.z, s.y), both(e.z, s.x, e.x, s.z), both(e.x, s.y, e.y, s.x)};
    return {dot(cross(edge, twice_middle), dir), hn::Mul(dot(permanent, dir_size), hn::Set(kTriangles, Pluecker::kBound))};
  }

  static HWY_INLINE void find(const TriangleBlock& block, const Ray& ray, Pluecker::RayData, std::size_t first,
                              Candidates& found) {
    const Vectors org = all_of(ray.org), dir = all_of(ray.dir), dir_size = magnitudes(dir);
    Vectors v[3];
    for (int i = 0; i < 3; ++i) v[i] = difference(vertices_of(block, i, first), org);
    const Volumes volume[3] = {volumes_of(v[1], v[2], dir, dir_size), volumes_of(v[2], v[0], dir, dir_size),
                               volumes_of(v[0], v[1], dir, dir_size)};
    const auto positive = [&](int i) HWY_ATTR { return hn::Ge(volume[i].value, hn::Neg(volume[i].error)); };
    const auto negative = [&](int i) HWY_ATTR { return hn::Le(volume[i].value, volume[i].error); };
    const auto front = hn::And(hn::And(positive(0), positive(1)), positive(2));
    const auto back = hn::And(hn::And(negative(0), negative(1)), negative(2));
    const auto inside = hn::Or(front, back);
    if (HWY_LIKELY(bits_of(kTriangles, inside) == 0)) return;

    const Triangles zero = hn::Zero(kTriangles), one = hn::Set(kTriangles, 1.0f);
    const Vectors normal = cross(difference(v[1], v[0]), difference(v[2], v[0]));
    const Triangles towards = dot(normal, dir), total = hn::Add(hn::Add(volume[0].value, volume[1].value), volume[2].value);
    const std::uint32_t hit = bits_of(kTriangles, hn::And(inside, hn::And(hn::Ne(towards, zero), hn::Ne(total, zero))));
    const auto share = [&](int i) HWY_ATTR { return least(most(hn::Div(volume[i].value, total), zero), one); };
    found.store(first, hit, hn::Div(dot(normal, v[0]), towards), share(1), share(2));
  }
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace accel
HWY_AFTER_NAMESPACE();

#endif
