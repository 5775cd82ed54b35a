#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "libaccel/packet/localized_simd.cpp"
#include <hwy/foreach_target.h>
// Above all other headers.
#include <hwy/highway.h>

#include <bit>

#include "libaccel/geometry/watertight.h"
#include "libaccel/packet/localized_simd.h"
#include "libaccel/packet/packet_simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace accel {
namespace HWY_NAMESPACE {
namespace {

const hn::Half<decltype(kFloats)> kHalfFloats;
const hn::Rebind<double, decltype(kHalfFloats)> kDoubles;
using Doubles = decltype(hn::Zero(kDoubles));

// The frustum of each group of a packet, between the planes of the packet's frustum. `begin` and `end` shrink as rays of the
// group hit something.
struct alignas(64) GroupFrustums {
  float begin[kMaxPacketSize], end[kMaxPacketSize];
  float lower[2][kMaxPacketSize], lower_slope[2][kMaxPacketSize], upper[2][kMaxPacketSize], upper_slope[2][kMaxPacketSize];
};

HWY_INLINE void begin_packet(const Frustum& frustum, Packet& p, GroupFrustums& groups) {
  const auto width = static_cast<std::uint32_t>(hn::Lanes(kFloats));
  p.kz = frustum.axis(), p.kx = frustum.side_axis(0), p.ky = frustum.side_axis(1);
  const float length = frustum.end - frustum.begin;
  const bool is_flat = !(length > frustum.slack);
  for (std::uint32_t i = 0, g = 0; i < p.lanes; i += width, ++g) {
    for (int a = 0; a < 3; ++a) hn::Store(hn::Div(set(1), load(p.dir[a] + i)), kFloats, p.inv[a] + i);
    const Floats dir_z = load(p.dir[p.kz] + i);
    hn::Store(hn::Div(load(p.dir[p.kx] + i), dir_z), kFloats, p.shear_x + i);
    hn::Store(hn::Div(load(p.dir[p.ky] + i), dir_z), kFloats, p.shear_y + i);
    hn::Store(hn::Set(kWords, kNoHit), kWords, p.prim_id + i);
    groups.begin[g] = frustum.begin, groups.end[g] = frustum.end;
    for (int s = 0; s < 2; ++s) {
      const Floats x0 = at_plane(p, i, p.kz, frustum.side_axis(s), frustum.begin);
      const Floats x1 = at_plane(p, i, p.kz, frustum.side_axis(s), frustum.end);
      const detail::Range first{least_lane(x0), most_lane(x0)}, last{least_lane(x1), most_lane(x1)};
      const Frustum::Side side = Frustum::side_between(first, last, length, is_flat, frustum.slack);
      groups.lower[s][g] = side.lower, groups.lower_slope[s][g] = side.lower_slope;
      groups.upper[s][g] = side.upper, groups.upper_slope[s][g] = side.upper_slope;
    }
  }
}

// Frustum::meets() of the groups from g on.
HWY_INLINE Mask groups_meet(const GroupFrustums& groups, std::uint32_t g, const Frustum& frustum, const OctoNode& node,
                            std::uint32_t c) {
  const int axis = frustum.axis();
  const Floats nearest = most(set(node.lower[axis][c]), load(groups.begin + g));
  const Floats farthest = least(set(node.upper[axis][c]), load(groups.end + g));
  Mask culled = hn::Gt(nearest, hn::Add(farthest, set(frustum.slack)));
  const Floats from = hn::Sub(nearest, set(frustum.begin)), to = hn::Sub(farthest, set(frustum.begin));
  for (int s = 0; s < 2; ++s) {
    const int a = frustum.side_axis(s);
    const Floats lower_slope = load(groups.lower_slope[s] + g), upper_slope = load(groups.upper_slope[s] + g);
    const Floats lower = hn::Add(load(groups.lower[s] + g), least(hn::Mul(lower_slope, from), hn::Mul(lower_slope, to)));
    const Floats upper = hn::Add(load(groups.upper[s] + g), most(hn::Mul(upper_slope, from), hn::Mul(upper_slope, to)));
    culled = hn::Or(culled, hn::Or(hn::Gt(lower, set(node.upper[a][c])), hn::Lt(upper, set(node.lower[a][c]))));
  }
  return hn::Not(culled);
}

// Draws the end of a group's frustum in, after some of its rays have hit something.
HWY_INLINE void shorten_group(const Packet& p, std::uint32_t i, const Frustum& frustum, GroupFrustums& groups) {
  const std::uint32_t g = i / static_cast<std::uint32_t>(hn::Lanes(kFloats));
  const Floats depth = hn::Add(load(p.org[p.kz] + i), hn::Mul(load(p.dir[p.kz] + i), load(p.t + i)));
  if ((frustum.face & 1u) != 0)
    groups.begin[g] = max_of(least_lane(depth), frustum.begin);
  else
    groups.end[g] = min_of(most_lane(depth), frustum.end);
}

// enters() of packet/localized.h.
HWY_INLINE Mask enter_box(const Packet& p, std::uint32_t i, const OctoNode& node, std::uint32_t c) {
  Floats enter = load(p.t_min + i), leave = load(p.t + i);
  for (int a = 0; a < 3; ++a) {
    const Floats org = load(p.org[a] + i), inv = load(p.inv[a] + i);
    const Floats lower = set(node.lower[a][c]), upper = set(node.upper[a][c]);
    const Mask backwards = hn::Lt(inv, set(0));
    const Floats near_t = hn::Mul(hn::Sub(hn::IfThenElse(backwards, upper, lower), org), inv);
    const Floats far_t = hn::Mul(hn::Sub(hn::IfThenElse(backwards, lower, upper), org), inv);
    enter = most(near_t, enter), leave = least(far_t, leave);
  }
  return hn::Le(enter, hn::Mul(leave, set(kFarScale)));
}

// A group of rays that enter a leaf.
struct Group {
  std::uint32_t first;  // lane
  std::uint8_t bits[8];
};

// What of a triangle all rays share.
struct Shared {
  const PackedTriangle& triangle;
  std::uint32_t prim_id;
  double normal[3];

  explicit Shared(const PackedTriangle& t) : triangle(t), prim_id(t.prim_id()) {
    double e1[3], e2[3];
    for (int a = 0; a < 3; ++a) {
      const float* const v = t.axis[a].vertex;
      const double v0 = v[0];
      e1[a] = v[1] - v0, e2[a] = v[2] - v0;
    }
    normal[0] = e1[1] * e2[2] - e1[2] * e2[1];
    normal[1] = e1[2] * e2[0] - e1[0] * e2[2];
    normal[2] = e1[0] * e2[1] - e1[1] * e2[0];
  }
};

// What locate() finds, and which vertices it takes, a ray each.
struct alignas(64) Located {
  float vertex[3][16], lowest[16], highest[16];
  float t[16], within[16];  // within: 1 or 0
};

// Watertight::plane_distance() and where it lies, in double, for as many rays as there are doubles in a vector.
HWY_INLINE void locate_part(const Packet& p, std::uint32_t i, const double normal[3], std::uint32_t part, Located& located) {
  const auto promote = [](const float* from) { return hn::PromoteTo(kDoubles, hn::Load(kHalfFloats, from)); };
  Doubles above = hn::Zero(kDoubles), below = above;
  for (int a = 0; a < 3; ++a) {
    const Doubles n = hn::Set(kDoubles, normal[a]);
    const Doubles s = hn::Mul(n, hn::Sub(promote(located.vertex[a] + part), promote(p.org[a] + i + part)));
    const Doubles d = hn::Mul(n, promote(p.dir[a] + i + part));
    above = a == 0 ? s : hn::Add(above, s);
    below = a == 0 ? d : hn::Add(below, d);
  }
  const Doubles t = hn::Div(above, below), depth = hn::Mul(t, promote(p.dir[p.kz] + i + part));
  const auto within = hn::And(hn::Ge(depth, promote(located.lowest + part)), hn::Le(depth, promote(located.highest + part)));
  const Doubles flag = hn::IfThenElse(within, hn::Set(kDoubles, 1.0), hn::Zero(kDoubles));
  hn::Store(hn::DemoteTo(kHalfFloats, t), kHalfFloats, located.t + part);
  hn::Store(hn::DemoteTo(kHalfFloats, flag), kHalfFloats, located.within + part);
}

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

struct Projected {
  Floats z[3], edge[3];
};

// Watertight::locate(): t.
HWY_INLINE Floats locate(const Packet& p, std::uint32_t i, const Shared& shared, const Projected& projected, Floats b0,
                         Floats u, Floats v) {
  Floats org[3], vertex[3];
  for (int a = 0; a < 3; ++a) org[a] = load(p.org[a] + i);
  nearest_vertex(shared.triangle, org, vertex);
  const Floats* const z = projected.z;
  const Floats nearest = least(least(z[0], z[1]), z[2]), farthest = most(most(z[0], z[1]), z[2]);
  const Floats rounding = set(kUnitRoundoff * 2);
  Located located;
  for (int a = 0; a < 3; ++a) hn::Store(vertex[a], kFloats, located.vertex[a]);
  hn::Store(hn::Sub(nearest, hn::Mul(rounding, hn::Abs(nearest))), kFloats, located.lowest);
  hn::Store(hn::Add(farthest, hn::Mul(rounding, hn::Abs(farthest))), kFloats, located.highest);
  for (std::uint32_t part = 0; part < hn::Lanes(kFloats); part += static_cast<std::uint32_t>(hn::Lanes(kDoubles)))
    locate_part(p, i, shared.normal, part, located);

  const Mask within = hn::Gt(load(located.within), hn::Zero(kFloats));
  if (HWY_LIKELY(hn::AllTrue(kFloats, within))) return load(located.t);
  const Floats depth = hn::Add(hn::Add(hn::Mul(b0, z[0]), hn::Mul(u, z[1])), hn::Mul(v, z[2]));
  return hn::IfThenElse(within, load(located.t), hn::Div(depth, load(p.dir[p.kz] + i)));
}

// Rays for which an edge function is zero, by the test of single rays. Returns how many have been answered.
template <Query kQuery>
HWY_NOINLINE std::uint32_t intersect_singly(Packet& p, std::uint32_t first, Mask mask, const Shared& shared) {
  std::uint8_t bits[8] = {};
  hn::StoreMaskBits(kFloats, mask, bits);
  std::uint32_t answered = 0;
  for (std::uint32_t rest = bits[0] | bits[1] << 8; rest != 0; rest &= rest - 1) {
    const std::uint32_t i = first + static_cast<std::uint32_t>(std::countr_zero(rest));
    const Ray& ray = p.rays[i];
    Hit candidate, hit{p.t[i], p.u[i], p.v[i], p.prim_id[i]};
    if (!Watertight::intersect(shared.triangle, ray, Watertight::prepare(ray), candidate)) continue;
    candidate.prim_id = shared.prim_id;
    if (!accept_hit(candidate, p.t_min[i], hit)) continue;
    p.t[i] = kQuery == Query::any ? -kInfinity : hit.t;
    p.u[i] = hit.u, p.v[i] = hit.v, p.prim_id[i] = hit.prim_id;
    ++answered;
  }
  return answered;
}

// A triangle against a group. Returns how many rays have a new answer.
template <Query kQuery>
HWY_INLINE std::uint32_t intersect_group(Packet& p, const Group& group, const Shared& shared) {
  const std::uint32_t i = group.first;
  const PackedTriangle::Quad *const axis = shared.triangle.axis, &qx = axis[p.kx], &qy = axis[p.ky], &qz = axis[p.kz];
  const Floats org_x = load(p.org[p.kx] + i), org_y = load(p.org[p.ky] + i), org_z = load(p.org[p.kz] + i);
  const Floats shear_x = load(p.shear_x + i), shear_y = load(p.shear_y + i);
  Projected projected;
  Floats x[3], y[3];
  for (int k = 0; k < 3; ++k) {
    const Floats z = hn::Sub(set(qz.vertex[k]), org_z);
    projected.z[k] = z;
    x[k] = hn::Sub(hn::Sub(set(qx.vertex[k]), org_x), hn::Mul(shear_x, z));
    y[k] = hn::Sub(hn::Sub(set(qy.vertex[k]), org_y), hn::Mul(shear_y, z));
  }
  Floats* const e = projected.edge;
  e[0] = hn::Sub(hn::Mul(x[2], y[1]), hn::Mul(y[2], x[1]));
  e[1] = hn::Sub(hn::Mul(x[0], y[2]), hn::Mul(y[0], x[2]));
  e[2] = hn::Sub(hn::Mul(x[1], y[0]), hn::Mul(y[1], x[0]));

  const Floats zero = hn::Zero(kFloats);
  const Mask not_negative = hn::And(hn::And(hn::Ge(e[0], zero), hn::Ge(e[1], zero)), hn::Ge(e[2], zero));
  const Mask not_positive = hn::And(hn::And(hn::Le(e[0], zero), hn::Le(e[1], zero)), hn::Le(e[2], zero));
  const Mask inside = hn::And(hn::Or(not_negative, not_positive), hn::LoadMaskBits(kFloats, group.bits));
  if (HWY_LIKELY(hn::AllFalse(kFloats, inside))) return 0;

  const Mask on_edge = hn::And(inside, hn::Or(hn::Or(hn::Eq(e[0], zero), hn::Eq(e[1], zero)), hn::Eq(e[2], zero)));
  std::uint32_t answered = 0;
  if (HWY_UNLIKELY(!hn::AllFalse(kFloats, on_edge))) answered = intersect_singly<kQuery>(p, i, on_edge, shared);

  const Floats det = hn::Add(hn::Add(e[0], e[1]), e[2]);
  const Floats b0 = hn::Div(e[0], det), u = hn::Div(e[1], det), v = hn::Div(e[2], det);
  const Floats t = locate(p, i, shared, projected, b0, u, v), best = load(p.t + i);
  const Words prim_id = hn::Load(kWords, p.prim_id + i), candidate = hn::Set(kWords, shared.prim_id);
  const Mask is_lower = hn::RebindMask(kFloats, hn::Lt(candidate, prim_id));
  Mask accepted = hn::And(hn::AndNot(on_edge, inside), hn::Ge(t, load(p.t_min + i)));
  accepted = hn::And(accepted, hn::Or(hn::Lt(t, best), hn::And(hn::Eq(t, best), is_lower)));
  if (hn::AllFalse(kFloats, accepted)) return answered;
  hn::Store(hn::IfThenElse(accepted, kQuery == Query::any ? set(-kInfinity) : t, best), kFloats, p.t + i);
  hn::Store(hn::IfThenElse(hn::RebindMask(kWords, accepted), candidate, prim_id), kWords, p.prim_id + i);
  if constexpr (kQuery == Query::closest) {
    hn::Store(hn::IfThenElse(accepted, u, load(p.u + i)), kFloats, p.u + i);
    hn::Store(hn::IfThenElse(accepted, v, load(p.v + i)), kFloats, p.v + i);
  }
  return answered + static_cast<std::uint32_t>(hn::CountTrue(kFloats, accepted));
}

// All rays against the leaf of a place. Returns how many new answers there are.
template <Query kQuery>
HWY_INLINE std::uint32_t intersect_leaf(const LocalizedBatch& batch, const Frustum& frustum, std::uint32_t place, Packet& p,
                                        GroupFrustums& frustums) {
  const OctoNode& node = batch.nodes[place / kOctoArity];
  const std::uint32_t c = place % kOctoArity, width = static_cast<std::uint32_t>(hn::Lanes(kFloats));
  Group groups[kMaxPacketSize];
  std::uint32_t group_count = 0;
  for (std::uint32_t g = 0; g * width < p.lanes; g += width) {
    std::uint8_t met[8] = {};
    hn::StoreMaskBits(kFloats, groups_meet(frustums, g, frustum, node, c), met);
    std::uint32_t bits = met[0] | met[1] << 8;
    const std::uint32_t left = p.lanes / width - g;
    if (left < width) bits &= (1u << left) - 1;
    for (; bits != 0; bits &= bits - 1) {
      const std::uint32_t i = (g + static_cast<std::uint32_t>(std::countr_zero(bits))) * width;
      const Mask mask = enter_box(p, i, node, c);
      groups[group_count].first = i;
      hn::StoreMaskBits(kFloats, mask, groups[group_count].bits);
      group_count += hn::AllFalse(kFloats, mask) ? 0 : 1;
    }
  }
  std::uint32_t answered = 0;
  if (group_count == 0) return answered;
  for (std::uint32_t quad = leaf_quad(node.child[c]); !is_end_of_leaf(batch.leaves, quad); quad += kQuadsPerTriangle) {
    const Shared shared(packed_triangle(batch.leaves, quad));
    for (std::uint32_t g = 0; g < group_count; ++g) {
      const std::uint32_t hits = intersect_group<kQuery>(p, groups[g], shared);
      if (hits > 0) shorten_group(p, groups[g].first, frustum, frustums);
      answered += hits;
    }
  }
  return answered;
}

template <Query kQuery, class Finish>
HWY_INLINE void intersect_packets(const LocalizedBatch& batch, const Finish& finish) {
  Packet packet;
  GroupFrustums groups;
  for (std::size_t i = 0; i < batch.count; ++i) {
    const std::uint32_t first = batch.packets[batch.active[i]], end = batch.packets[batch.active[i] + 1];
    const Frustum& frustum = batch.frustums[i];
    load_rays(batch.rays, batch.ids + first, end - first, packet);
    begin_packet(frustum, packet, groups);
    std::uint32_t answered = 0;
    for (std::uint32_t at = batch.firsts[i]; at < batch.firsts[i + 1]; ++at) {
      answered += intersect_leaf<kQuery>(batch, frustum, leaf_quad(batch.places[at]), packet, groups);
      if (kQuery == Query::any && answered == packet.size) break;
    }
    for (std::uint32_t r = 0; r < packet.size; ++r) finish(packet, r, batch.ids[first + r]);
  }
}

void intersect(const LocalizedBatch& batch, Hit* hits) {
  intersect_packets<Query::closest>(batch, [=](const Packet& p, std::uint32_t r, std::uint32_t ray) {
    hits[ray] = p.prim_id[r] == kNoHit ? Hit{} : Hit{p.t[r], p.u[r], p.v[r], p.prim_id[r]};
  });
}

void occlude(const LocalizedBatch& batch, std::uint8_t* occluded) {
  intersect_packets<Query::any>(
      batch, [=](const Packet& p, std::uint32_t r, std::uint32_t ray) { occluded[ray] = p.prim_id[r] == kNoHit ? 0 : 1; });
}

const char* target_name() { return hwy::TargetName(HWY_TARGET); }

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace accel
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace accel {
HWY_EXPORT(intersect);
HWY_EXPORT(occlude);
HWY_EXPORT(target_name);

void intersect_watertight_simd(const LocalizedBatch& batch, Hit* hits) { HWY_DYNAMIC_DISPATCH(intersect)(batch, hits); }
void occlude_watertight_simd(const LocalizedBatch& batch, std::uint8_t* occluded) {
  HWY_DYNAMIC_DISPATCH(occlude)(batch, occluded);
}
const char* packet_simd_target() { return HWY_DYNAMIC_DISPATCH(target_name)(); }
}  // namespace accel
#endif
