#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "libaccel/packet/ray_groups_simd.cpp"
#include <hwy/foreach_target.h>
// Above all other headers.
#include <hwy/highway.h>

#include "libaccel/packet/packet_simd-inl.h"
#include "libaccel/packet/ray_groups_simd.h"
#include "libaccel/packet/watertight_simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace accel {
namespace HWY_NAMESPACE {
namespace {

// The part of a group that box tests read.
struct Boxes {
  Floats org[3], inv[3], t_min;
  std::uint32_t near_at[3];  // as in ScalarBoxPairTest, where all rays go the same way
};

// A child that some rays enter, each at its distance; NaN for the others.
struct alignas(64) Postponed {
  float t_near[16];
  NodeRef node;
};

struct Entered {
  Mask mask;
  Floats t_near;
};

// Child c of the node, by the rays of `active`. kOneWay: all rays of the group go the same way along each axis.
template <bool kOneWay>
HWY_INLINE Entered enter_child(const Boxes& boxes, const Bvh2Node& node, std::uint32_t c, Mask active, Floats t_max) {
  Floats enter = boxes.t_min, leave = t_max;
  for (int a = 0; a < 3; ++a) {
    Floats near_plane, far_plane;
    if constexpr (kOneWay) {
      near_plane = set(node.planes[a][c + boxes.near_at[a]]), far_plane = set(node.planes[a][c + (boxes.near_at[a] ^ 2u)]);
    } else {
      const Floats lower = set(node.planes[a][c]), upper = set(node.planes[a][2 + c]);
      const Mask backwards = hn::Lt(boxes.inv[a], hn::Zero(kFloats));
      near_plane = hn::IfThenElse(backwards, upper, lower), far_plane = hn::IfThenElse(backwards, lower, upper);
    }
    enter = most(hn::Mul(hn::Sub(near_plane, boxes.org[a]), boxes.inv[a]), enter);
    leave = least(hn::Mul(hn::Sub(far_plane, boxes.org[a]), boxes.inv[a]), leave);
  }
  return {hn::And(active, hn::Le(enter, hn::Mul(leave, set(kFarScale)))), enter};
}

template <Query kQuery>
HWY_INLINE void intersect_leaf(const LeafQuad* leaves, NodeRef leaf, Mask active, std::uint32_t first, Packet& p) {
  for (std::uint32_t quad = leaf_quad(leaf); !is_end_of_leaf(leaves, quad); quad += kQuadsPerTriangle)
    GroupTest<kQuery, LoneTriangle>(p, {packed_triangle(leaves, quad)}).intersect(first, active);
}

HWY_INLINE void postpone(Postponed& entry, NodeRef node, const Entered& at) {
  entry.node = node;
  hn::Store(hn::IfThenElse(at.mask, at.t_near, set(std::numeric_limits<float>::quiet_NaN())), kFloats, entry.t_near);
}

// The rays from lane `first` on.
template <Query kQuery, bool kOneWay>
HWY_INLINE void trace_group(const Bvh2View& view, const Boxes& boxes, std::uint32_t first, Packet& p, GroupWork& work) {
  Postponed stack[kBvh2StackSize];
  Postponed* top = stack;
  NodeRef ref = view.root;
  Floats t_max = load(p.t + first);
  Mask active = hn::Ge(t_max, hn::Zero(kFloats));
  for (;;) {
    while (!is_leaf(ref)) {
      const Bvh2Node& node = view.nodes[ref];
      ++work.nodes, work.rays += hn::CountTrue(kFloats, active);
      const Entered left = enter_child<kOneWay>(boxes, node, 0, active, t_max);
      const Entered right = enter_child<kOneWay>(boxes, node, 1, active, t_max);
      const bool enters_left = !hn::AllFalse(kFloats, left.mask), enters_right = !hn::AllFalse(kFloats, right.mask);
      if (!enters_left && !enters_right) goto backtrack;
      if (enters_left && enters_right) {
        // The child that is nearer for most rays of both.
        const Mask both = hn::And(left.mask, right.mask);
        const bool right_first =
            2 * hn::CountTrue(kFloats, hn::And(both, hn::Lt(right.t_near, left.t_near))) > hn::CountTrue(kFloats, both);
        postpone(*top++, node.child[right_first ? 0 : 1], right_first ? left : right);
        ref = node.child[right_first ? 1 : 0], active = right_first ? right.mask : left.mask;
      } else {
        ref = node.child[enters_left ? 0 : 1], active = enters_left ? left.mask : right.mask;
      }
    }
    intersect_leaf<kQuery>(view.leaves, ref, active, first, p);
    t_max = load(p.t + first);
  backtrack:
    do {
      if (top == stack) return;
      --top;
      ref = top->node, active = hn::Le(load(top->t_near), hn::Mul(t_max, set(kFarScale)));
    } while (hn::AllFalse(kFloats, active));
  }
}

template <Query kQuery>
HWY_INLINE void trace_packet(const Bvh2View& view, Packet& p, GroupWork& work) {
  for (std::uint32_t i = 0; i < p.lanes; i += width()) {
    Boxes boxes;
    boxes.t_min = load(p.t_min + i);
    bool one_way = true;
    for (int a = 0; a < 3; ++a) {
      boxes.org[a] = load(p.org[a] + i), boxes.inv[a] = load(p.inv[a] + i);
      const Mask backwards = hn::Lt(boxes.inv[a], hn::Zero(kFloats));
      boxes.near_at[a] = hn::AllFalse(kFloats, backwards) ? 0 : 2;
      one_way = one_way && (boxes.near_at[a] == 0 || hn::AllTrue(kFloats, backwards));
    }
    if (HWY_LIKELY(one_way))
      trace_group<kQuery, true>(view, boxes, i, p, work);
    else
      trace_group<kQuery, false>(view, boxes, i, p, work);
  }
}

template <Query kQuery, class Answer>
HWY_INLINE GroupWork trace_packets(const Bvh2View& view, const LocalizedBatch& batch, const std::uint8_t* faces,
                                   Answer* answers) {
  Packet packet;
  GroupWork work;
  for (std::size_t i = 0; i < batch.count; ++i) {
    const std::uint32_t first = batch.packets[batch.active[i]], end = batch.packets[batch.active[i] + 1];
    load_rays(batch.rays, batch.ids + first, end - first, faces[first] >> 1, packet);
    trace_packet<kQuery>(view, packet, work);
    store_answers(packet, answers);
  }
  return work;
}

GroupWork intersect(const Bvh2View& view, const LocalizedBatch& batch, const std::uint8_t* faces, Hit* hits) {
  return trace_packets<Query::closest>(view, batch, faces, hits);
}
GroupWork occlude(const Bvh2View& view, const LocalizedBatch& batch, const std::uint8_t* faces, std::uint8_t* occluded) {
  return trace_packets<Query::any>(view, batch, faces, occluded);
}

std::uint32_t lanes() { return width(); }

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace accel
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace accel {
HWY_EXPORT(intersect);
HWY_EXPORT(occlude);
HWY_EXPORT(lanes);

GroupWork intersect_groups_simd(const Bvh2View& view, const LocalizedBatch& batch, const std::uint8_t* faces, Hit* hits) {
  return HWY_DYNAMIC_DISPATCH(intersect)(view, batch, faces, hits);
}
GroupWork occlude_groups_simd(const Bvh2View& view, const LocalizedBatch& batch, const std::uint8_t* faces,
                              std::uint8_t* occluded) {
  return HWY_DYNAMIC_DISPATCH(occlude)(view, batch, faces, occluded);
}
std::uint32_t rays_per_group() { return HWY_DYNAMIC_DISPATCH(lanes)(); }
}  // namespace accel
#endif
