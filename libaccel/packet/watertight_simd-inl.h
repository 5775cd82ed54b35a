// Triangles against groups of rays, one ray in each SIMD lane: the operations of geometry/watertight.h, hence its hits, bit for
// bit. The guard lets the header through once for each target that Highway compiles.
#if defined(ACCEL_WATERTIGHT_SIMD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ACCEL_WATERTIGHT_SIMD_INL_H
#undef ACCEL_WATERTIGHT_SIMD_INL_H
#else
#define ACCEL_WATERTIGHT_SIMD_INL_H
#endif

#include <hwy/highway.h>

#include <bit>
#include <cmath>
#include <cstdint>

#include "libaccel/geometry/located_bounds.h"
#include "libaccel/geometry/watertight.h"
#include "libaccel/packet/packet_simd-inl.h"
#include "libaccel/structure/triangle_block.h"

HWY_BEFORE_NAMESPACE();
namespace accel {
namespace HWY_NAMESPACE {
namespace {

const hn::Half<decltype(kFloats)> kHalfFloats;
const hn::Rebind<double, decltype(kHalfFloats)> kDoubles;
using HalfFloats = decltype(hn::Zero(kHalfFloats));
using Doubles = decltype(hn::Zero(kDoubles));

// Of the nearest of three vertices by Watertight::nearest_vertex().
HWY_INLINE void nearest_vertex(const PackedTriangle& triangle, const Floats org[3], Floats vertex[3]) {
  Floats d[3];
  for (int i = 0; i < 3; ++i) {
    Floats far = hn::Abs(hn::Sub(set(triangle.axis[0].vertex[i]), org[0]));
    far = most(far, hn::Abs(hn::Sub(set(triangle.axis[1].vertex[i]), org[1])));
    d[i] = most(far, hn::Abs(hn::Sub(set(triangle.axis[2].vertex[i]), org[2])));
  }
  const Mask second = hn::Lt(d[1], d[0]), third = hn::Lt(d[2], least(d[1], d[0]));
  for (int a = 0; a < 3; ++a) {
    const float* const v = triangle.axis[a].vertex;
    vertex[a] = hn::IfThenElse(third, set(v[2]), hn::IfThenElse(second, set(v[1]), set(v[0])));
  }
}

// Of the plane, as Watertight::plane_distance() has it. Returns the product of the 1-norms of two edges.
HWY_INLINE double find_normal(const PackedTriangle& triangle, double normal[3]) {
  double e1[3], e2[3];
  for (int a = 0; a < 3; ++a) {
    const float* const v = triangle.axis[a].vertex;
    const double v0 = v[0];
    e1[a] = v[1] - v0, e2[a] = v[2] - v0;
  }
  normal[0] = e1[1] * e2[2] - e1[2] * e2[1];
  normal[1] = e1[2] * e2[0] - e1[0] * e2[2];
  normal[2] = e1[0] * e2[1] - e1[1] * e2[0];
  return (std::fabs(e1[0]) + std::fabs(e1[1]) + std::fabs(e1[2])) * (std::fabs(e2[0]) + std::fabs(e2[1]) + std::fabs(e2[2]));
}

// Rays for which an edge function is zero, by the test of single rays. Returns how many have been answered.
template <Query kQuery>
HWY_NOINLINE std::uint32_t intersect_singly(Packet& p, std::uint32_t first, Mask mask, const PackedTriangle& triangle) {
  std::uint8_t bits[8] = {};
  hn::StoreMaskBits(kFloats, mask, bits);
  std::uint32_t answered = 0;
  for (std::uint32_t rest = bits[0] | bits[1] << 8; rest != 0; rest &= rest - 1) {
    const std::uint32_t i = first + static_cast<std::uint32_t>(std::countr_zero(rest));
    const Ray ray = p.ray(i);
    Hit candidate, hit{p.t[i], p.u[i], p.v[i], p.prim_id[i]};
    if (!Watertight::intersect(triangle, ray, Watertight::prepare(ray), candidate)) continue;
    candidate.prim_id = triangle.prim_id();
    if (!accept_hit(candidate, p.t_min[i], hit)) continue;
    p.t[i] = kQuery == Query::any ? -kInfinity : hit.t;
    p.u[i] = hit.u, p.v[i] = hit.v, p.prim_id[i] = hit.prim_id;
    ++answered;
  }
  return answered;
}

// Of LocatedBounds, for all rays of the packet in a scene within `bounds`.
HWY_INLINE float reach_of(const Packet& p, const Aabb& bounds) {
  Floats least_dir = set(kInfinity), most_dir = hn::Zero(kFloats);
  for (std::uint32_t i = 0; i < p.lanes; i += width()) {
    const Floats along = hn::Abs(load(p.dir[p.kz] + i));
    least_dir = least(along, least_dir), most_dir = most(along, most_dir);
  }
  return LocatedBounds::reach(bounds, p.largest_origin, least_lane(least_dir), most_lane(most_dir));
}

// Triangles as they are tested: by themselves, or those of a block, whose vertices have been moved to the origin that all rays
// of a packet have. Coordinate a of vertex k is vertex(a, k), and relative(a, k) once it is moved.
struct LoneTriangle {
  static constexpr bool kIsRelative = false;
  const PackedTriangle& triangle;

  HWY_INLINE float vertex(int a, int k) const { return triangle.axis[a].vertex[k]; }
  HWY_INLINE std::uint32_t prim_id() const { return triangle.prim_id(); }
  HWY_INLINE const PackedTriangle& packed() const { return triangle; }
};

struct alignas(64) RelativeVertices {
  float vertex[3][3][kBlockLanes];

  HWY_INLINE RelativeVertices(const TriangleBlock& block, const float origin[3]) {
    const hn::CappedTag<float, kBlockLanes> lanes;
    for (int a = 0; a < 3; ++a)
      for (int k = 0; k < 3; ++k)
        for (std::uint32_t i = 0; i < kBlockLanes; i += static_cast<std::uint32_t>(hn::Lanes(lanes)))
          hn::Store(hn::Sub(hn::Load(lanes, block.vertex[a][k] + i), hn::Set(lanes, origin[a])), lanes, vertex[a][k] + i);
  }
};
struct RelativeTriangle {
  static constexpr bool kIsRelative = true;
  const TriangleBlock& block;
  const RelativeVertices& vertices;
  std::uint32_t lane;

  HWY_INLINE float relative(int a, int k) const { return vertices.vertex[a][k][lane]; }
  HWY_INLINE float vertex(int a, int k) const { return block.vertex[a][k][lane]; }
  HWY_INLINE std::uint32_t prim_id() const { return block.prim_id[lane]; }
  HWY_INLINE PackedTriangle packed() const { return block.packed(lane); }
};

// A triangle against groups of rays of a packet: what they share is computed once.
template <Query kQuery, class Triangle>
class GroupTest {
 public:
  HWY_INLINE GroupTest(Packet& packet, const Triangle& triangle) : p_(packet), triangle_(triangle) {}

  // The rays of the mask, from lane i on. Returns how many have a new answer.
  HWY_INLINE std::uint32_t intersect(std::uint32_t i, Mask mask) {
    const Floats shear_x = load(p_.shear[0] + i), shear_y = load(p_.shear[1] + i);
    Projected projected;
    Floats x[3], y[3];
    for (int k = 0; k < 3; ++k) {
      const Floats z = vertex(p_.kz, k, i);
      projected.z[k] = z;
      x[k] = hn::Sub(vertex(p_.kx, k, i), hn::Mul(shear_x, z));
      y[k] = hn::Sub(vertex(p_.ky, k, i), hn::Mul(shear_y, z));
    }
    Floats* const e = projected.edge;
    e[0] = hn::Sub(hn::Mul(x[2], y[1]), hn::Mul(y[2], x[1]));
    e[1] = hn::Sub(hn::Mul(x[0], y[2]), hn::Mul(y[0], x[2]));
    e[2] = hn::Sub(hn::Mul(x[1], y[0]), hn::Mul(y[1], x[0]));

    const Floats zero = hn::Zero(kFloats);
    const Mask not_negative = hn::And(hn::And(hn::Ge(e[0], zero), hn::Ge(e[1], zero)), hn::Ge(e[2], zero));
    const Mask not_positive = hn::And(hn::And(hn::Le(e[0], zero), hn::Le(e[1], zero)), hn::Le(e[2], zero));
    const Mask inside = hn::And(hn::Or(not_negative, not_positive), mask);
    if (HWY_LIKELY(hn::AllFalse(kFloats, inside))) return 0;

    const Mask on_edge = hn::And(inside, hn::Or(hn::Or(hn::Eq(e[0], zero), hn::Eq(e[1], zero)), hn::Eq(e[2], zero)));
    std::uint32_t answered = 0;
    if (HWY_UNLIKELY(!hn::AllFalse(kFloats, on_edge))) answered = intersect_singly<kQuery>(p_, i, on_edge, triangle_.packed());
    return answered + accept(i, inside, on_edge, projected);
  }

 private:
  static constexpr bool kOneOrigin = Triangle::kIsRelative;

  // Depths along the axis kz relative to the origin, and edge functions.
  struct Projected {
    Floats z[3], edge[3];
  };
  // What Watertight::plane_distance() computes of the plane, and of one origin; and the bounds of depths within the triangle.
  struct Plane {
    double normal[3], above;
    float lowest, highest;
    LocatedBounds bounds;
  };

  // Vertex k relative to the rays' origins.
  HWY_INLINE Floats vertex(int axis, int k, std::uint32_t i) const {
    if constexpr (kOneOrigin)
      return set(triangle_.relative(axis, k));
    else
      return hn::Sub(set(triangle_.vertex(axis, k)), load(p_.org[axis] + i));
  }

  // Takes the hits of rays that are inside, on no edge, and meet nothing nearer. Returns how many there are.
  HWY_INLINE std::uint32_t accept(std::uint32_t i, Mask inside, Mask on_edge, const Projected& projected) {
    const Floats* const e = projected.edge;
    const Floats det = hn::Add(hn::Add(e[0], e[1]), e[2]), best = load(p_.t + i);
    const Words prim_id = hn::Load(kWords, p_.prim_id + i), candidate = hn::Set(kWords, triangle_.prim_id());
    Mask accepted = hn::AndNot(on_edge, inside);
    Floats t = best;
    if (!decide(i, projected, accepted)) {
      t = locate(i, inside, projected, det);
      const Mask is_lower = hn::RebindMask(kFloats, hn::Lt(candidate, prim_id));
      accepted = hn::And(accepted, hn::Ge(t, load(p_.t_min + i)));
      accepted = hn::And(accepted, hn::Or(hn::Lt(t, best), hn::And(hn::Eq(t, best), is_lower)));
    }
    if (hn::AllFalse(kFloats, accepted)) return 0;
    hn::Store(hn::IfThenElse(accepted, kQuery == Query::any ? set(-kInfinity) : t, best), kFloats, p_.t + i);
    hn::Store(hn::IfThenElse(hn::RebindMask(kWords, accepted), candidate, prim_id), kWords, p_.prim_id + i);
    if constexpr (kQuery == Query::closest) {
      hn::Store(hn::IfThenElse(accepted, hn::Div(e[1], det), load(p_.u + i)), kFloats, p_.u + i);
      hn::Store(hn::IfThenElse(accepted, hn::Div(e[2], det), load(p_.v + i)), kFloats, p_.v + i);
    }
    return static_cast<std::uint32_t>(hn::CountTrue(kFloats, accepted));
  }

  // Leaves the candidates that are hit, if bounds of t say so of all; or leaves them as they are, and returns false. Of closest
  // hits t is wanted, and rays of one origin have it for little more.
  HWY_INLINE bool decide(std::uint32_t i, const Projected& projected, Mask& candidates) {
    if (kQuery != Query::any || kOneOrigin || p_.reach == kInfinity) return false;
    const Interval t = bounds_of_t(i, projected);
    const Floats begin = load(p_.t_min + i), end = load(p_.t + i);
    const Mask hit = hn::And(hn::Ge(t.least, begin), hn::Le(t.most, end));
    const Mask missed = hn::Or(hn::Lt(t.most, begin), hn::Gt(t.least, end));
    if (!hn::AllFalse(kFloats, hn::AndNot(hn::Or(hit, missed), candidates))) return false;
    candidates = hn::And(candidates, hit);
    return true;
  }

  struct Interval {
    Floats least, most;
  };

  // LocatedBounds::of() the rays from lane i on; a contracted sum has less of an error.
  HWY_INLINE Interval bounds_of_t(std::uint32_t i, const Projected& projected) {
    if (!has_plane_) find_plane();
    const LocatedBounds& bounds = plane_.bounds;
    Floats s = hn::Zero(kFloats), d = s, products = s;
    for (int a = 0; a < 3; ++a) {
      const Floats n = set(bounds.normal[a]);
      const Floats product = hn::Mul(n, hn::Sub(set(triangle_.vertex(a, 0)), load(p_.org[a] + i)));
      s = hn::Add(s, product), products = hn::Add(products, hn::Abs(product));
      d = hn::MulAdd(n, load(p_.dir[a] + i), d);
    }
    const Floats dir_z = load(p_.dir[p_.kz] + i), inv_d = hn::Div(set(1), d), t = hn::Mul(s, inv_d);
    const Floats depth = hn::Mul(s, hn::Mul(dir_z, inv_d));
    Floats error = hn::MulAdd(products, set(LocatedBounds::kOfProducts), set(bounds.of_doubles));
    error = hn::Mul(hn::MulAdd(hn::Abs(depth), set(bounds.of_depth), error), hn::Abs(inv_d));

    const Floats inv = load(p_.inv[p_.kz] + i);
    const Floats at[] = {hn::Mul(projected.z[0], inv), hn::Mul(projected.z[1], inv), hn::Mul(projected.z[2], inv)};
    const Floats nearest = least(least(at[0], at[1]), at[2]), farthest = most(most(at[0], at[1]), at[2]);
    const Floats largest = most(hn::Abs(nearest), hn::Abs(farthest));
    const Floats slack = hn::MulAdd(largest, set(LocatedBounds::kOfVertices), set(LocatedBounds::kOfUnderflow));
    const Floats lower = hn::Sub(t, error), upper = hn::Add(t, error);
    Mask is_plane = hn::Ge(hn::Abs(d), hn::Mul(set(bounds.least_d), hn::Abs(dir_z)));
    is_plane = hn::And(is_plane, hn::And(hn::Ge(hn::Sub(lower, slack), nearest), hn::Le(hn::Add(upper, slack), farthest)));
    return {hn::IfThenElse(is_plane, lower, hn::Sub(nearest, slack)),
            hn::IfThenElse(is_plane, upper, hn::Add(farthest, slack))};
  }

  // Watertight::locate(): t of the lanes of the mask.
  HWY_INLINE Floats locate(std::uint32_t i, Mask mask, const Projected& projected, Floats det) {
    if (!has_plane_) find_plane();
    Nearest nearest;
    if constexpr (!kOneOrigin) find_nearest(i, projected, nearest);
#if HWY_TARGET == HWY_SCALAR
    const Located located = locate_half(i, 0, nearest);
    const Floats t = located.t, within = located.within;
#else
    const Located lower = locate_half(i, 0, nearest),
                  upper = locate_half(i, static_cast<std::uint32_t>(hn::Lanes(kDoubles)), nearest);
    const Floats t = hn::Combine(kFloats, upper.t, lower.t), within = hn::Combine(kFloats, upper.within, lower.within);
#endif

    const Floats *const z = projected.z, *const e = projected.edge;
    const Mask beyond = hn::AndNot(hn::Gt(within, hn::Zero(kFloats)), mask);
    if (HWY_LIKELY(hn::AllFalse(kFloats, beyond))) return t;
    const Floats b0 = hn::Div(e[0], det), u = hn::Div(e[1], det), v = hn::Div(e[2], det);
    const Floats depth = hn::Add(hn::Add(hn::Mul(b0, z[0]), hn::Mul(u, z[1])), hn::Mul(v, z[2]));
    return hn::IfThenElse(beyond, hn::Div(depth, load(p_.dir[p_.kz] + i)), t);
  }

  // By ray, where origins differ: the vertex that is taken, and bounds of depths.
  struct alignas(64) Nearest {
    float vertex[3][16], lowest[16], highest[16];
  };
  // Of as many rays as there are doubles in a vector: t, and whether it lies within bounds: 1 or 0.
  struct Located {
    HalfFloats t, within;
  };

  HWY_INLINE void find_plane() {
    const PackedTriangle& triangle = triangle_.packed();
    const double edges = find_normal(triangle, plane_.normal);
    has_plane_ = true;
    if constexpr (kQuery == Query::any && !kOneOrigin) plane_.bounds = LocatedBounds(plane_.normal, edges, p_.reach);
    if constexpr (kOneOrigin) {
      const int k = Watertight::nearest_vertex(triangle, {p_.origin[0], p_.origin[1], p_.origin[2]});
      for (int a = 0; a < 3; ++a) {
        const double s = plane_.normal[a] * (static_cast<double>(triangle.axis[a].vertex[k]) - p_.origin[a]);
        plane_.above = a == 0 ? s : plane_.above + s;
      }
      const float z[] = {triangle_.relative(p_.kz, 0), triangle_.relative(p_.kz, 1), triangle_.relative(p_.kz, 2)};
      const float nearest = min_of(min_of(z[0], z[1]), z[2]), farthest = max_of(max_of(z[0], z[1]), z[2]);
      plane_.lowest = nearest - kUnitRoundoff * 2 * std::fabs(nearest);
      plane_.highest = farthest + kUnitRoundoff * 2 * std::fabs(farthest);
    }
  }

  HWY_INLINE void find_nearest(std::uint32_t i, const Projected& projected, Nearest& found) const {
    Floats org[3], vertex[3];
    for (int a = 0; a < 3; ++a) org[a] = load(p_.org[a] + i);
    nearest_vertex(triangle_.packed(), org, vertex);
    for (int a = 0; a < 3; ++a) hn::Store(vertex[a], kFloats, found.vertex[a]);
    const Floats* const z = projected.z;
    const Floats nearest = least(least(z[0], z[1]), z[2]), farthest = most(most(z[0], z[1]), z[2]);
    const Floats rounding = set(kUnitRoundoff * 2);
    hn::Store(hn::Sub(nearest, hn::Mul(rounding, hn::Abs(nearest))), kFloats, found.lowest);
    hn::Store(hn::Add(farthest, hn::Mul(rounding, hn::Abs(farthest))), kFloats, found.highest);
  }

  // Watertight::plane_distance() and where it lies, in double, of the rays from lane i + part on.
  HWY_INLINE Located locate_half(std::uint32_t i, std::uint32_t part, const Nearest& nearest) const {
    const auto promote = [](const float* from) HWY_ATTR { return hn::PromoteTo(kDoubles, hn::Load(kHalfFloats, from)); };
    Doubles above = hn::Set(kDoubles, plane_.above), below = hn::Zero(kDoubles);
    for (int a = 0; a < 3; ++a) {
      const Doubles n = hn::Set(kDoubles, plane_.normal[a]), d = hn::Mul(n, promote(p_.dir[a] + i + part));
      below = a == 0 ? d : hn::Add(below, d);
      if constexpr (!kOneOrigin) {
        const Doubles s = hn::Mul(n, hn::Sub(promote(nearest.vertex[a] + part), promote(p_.org[a] + i + part)));
        above = a == 0 ? s : hn::Add(above, s);
      }
    }
    const Doubles lowest = kOneOrigin ? hn::Set(kDoubles, plane_.lowest) : promote(nearest.lowest + part);
    const Doubles highest = kOneOrigin ? hn::Set(kDoubles, plane_.highest) : promote(nearest.highest + part);
    const Doubles t = hn::Div(above, below), depth = hn::Mul(t, promote(p_.dir[p_.kz] + i + part));
    const auto within = hn::And(hn::Ge(depth, lowest), hn::Le(depth, highest));
    const Doubles flag = hn::IfThenElse(within, hn::Set(kDoubles, 1.0), hn::Zero(kDoubles));
    return {hn::DemoteTo(kHalfFloats, t), hn::DemoteTo(kHalfFloats, flag)};
  }

  Packet& p_;
  const Triangle triangle_;
  bool has_plane_ = false;
  Plane plane_{};
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace accel
HWY_AFTER_NAMESPACE();

#endif
