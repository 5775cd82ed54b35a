#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "libaccel/packet/localized_simd.cpp"
#include <hwy/foreach_target.h>
// Above all other headers.
#include <hwy/highway.h>

#include <bit>

#include "libaccel/packet/localized_simd.h"
#include "libaccel/packet/packet_simd-inl.h"
#include "libaccel/packet/watertight_simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace accel {
namespace HWY_NAMESPACE {
namespace {

// The frustum of each group of a packet, between the planes of the packet's frustum. `begin` and `end` shrink as rays of the
// group hit something.
struct alignas(64) GroupFrustums {
  float begin[kMaxPacketSize], end[kMaxPacketSize];
  float lower[2][kMaxPacketSize], lower_slope[2][kMaxPacketSize], upper[2][kMaxPacketSize], upper_slope[2][kMaxPacketSize];
};

HWY_INLINE void begin_groups(const Frustum& frustum, const Packet& p, GroupFrustums& groups) {
  const float length = frustum.end - frustum.begin;
  const bool is_flat = !(length > frustum.slack);
  for (std::uint32_t i = 0, g = 0; i < p.lanes; i += width(), ++g) {
    groups.begin[g] = frustum.begin, groups.end[g] = frustum.end;
    for (int s = 0; s < 2; ++s) {
      const Floats x0 = at_plane(p, i, s, frustum.begin);
      const Floats x1 = at_plane(p, i, s, frustum.end);
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
  const std::uint32_t g = i / width();
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

// All rays against the leaf of a place. Returns how many new answers there are.
template <Query kQuery>
HWY_INLINE std::uint32_t intersect_leaf(const LocalizedBatch& batch, const Frustum& frustum, std::uint32_t place, Packet& p,
                                        GroupFrustums& frustums) {
  const OctoNode& node = batch.nodes[place / kOctoArity];
  const std::uint32_t c = place % kOctoArity;
  Group groups[kMaxPacketSize];
  std::uint32_t group_count = 0;
  for (std::uint32_t g = 0; g * width() < p.lanes; g += width()) {
    std::uint8_t met[8] = {};
    hn::StoreMaskBits(kFloats, groups_meet(frustums, g, frustum, node, c), met);
    std::uint32_t bits = met[0] | met[1] << 8;
    const std::uint32_t left = p.lanes / width() - g;
    if (left < width()) bits &= (1u << left) - 1;
    for (; bits != 0; bits &= bits - 1) {
      const std::uint32_t i = (g + static_cast<std::uint32_t>(std::countr_zero(bits))) * width();
      const Mask mask = enter_box(p, i, node, c);
      groups[group_count].first = i;
      hn::StoreMaskBits(kFloats, mask, groups[group_count].bits);
      group_count += hn::AllFalse(kFloats, mask) ? 0 : 1;
    }
  }
  std::uint32_t answered = 0;
  if (group_count == 0) return answered;
  for (std::uint32_t quad = leaf_quad(node.child[c]); !is_end_of_leaf(batch.leaves, quad); quad += kQuadsPerTriangle) {
    GroupTest<kQuery, LoneTriangle> triangle(p, {packed_triangle(batch.leaves, quad)});
    for (std::uint32_t g = 0; g < group_count; ++g) {
      const Mask mask = hn::LoadMaskBits(kFloats, groups[g].bits);
      const std::uint32_t hits = triangle.intersect(groups[g].first, mask);
      if (hits > 0) shorten_group(p, groups[g].first, frustum, frustums);
      answered += hits;
    }
  }
  return answered;
}

template <Query kQuery, class Answer>
HWY_INLINE void intersect_packets(const LocalizedBatch& batch, Answer* answers) {
  Packet packet;
  GroupFrustums groups;
  for (std::size_t i = 0; i < batch.count; ++i) {
    const std::uint32_t first = batch.packets[batch.active[i]], end = batch.packets[batch.active[i] + 1];
    const Frustum& frustum = batch.frustums[i];
    load_rays(batch.rays, batch.ids + first, end - first, frustum.axis(), packet);
    begin_groups(frustum, packet, groups);
    std::uint32_t answered = 0;
    for (std::uint32_t at = batch.firsts[i]; at < batch.firsts[i + 1]; ++at) {
      answered += intersect_leaf<kQuery>(batch, frustum, leaf_quad(batch.places[at]), packet, groups);
      if (kQuery == Query::any && answered == packet.size) break;
    }
    store_answers(packet, answers);
  }
}

void intersect(const LocalizedBatch& batch, Hit* hits) { intersect_packets<Query::closest>(batch, hits); }
void occlude(const LocalizedBatch& batch, std::uint8_t* occluded) { intersect_packets<Query::any>(batch, occluded); }

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
