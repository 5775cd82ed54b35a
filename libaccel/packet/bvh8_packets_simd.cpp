#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "libaccel/packet/bvh8_packets_simd.cpp"
#include <hwy/foreach_target.h>
// Above all other headers.
#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <memory>

#include "libaccel/packet/bvh8_packets_simd.h"
#include "libaccel/packet/frustum_boxes_simd-inl.h"
#include "libaccel/packet/frustum_simd-inl.h"
#include "libaccel/packet/packet_simd-inl.h"
#include "libaccel/packet/pencil_simd-inl.h"
#include "libaccel/packet/watertight_simd-inl.h"
#include "libaccel/trace/bvh8_ray.h"
#include "libaccel/trace/bvh8_simd.h"

HWY_BEFORE_NAMESPACE();
namespace accel {
namespace HWY_NAMESPACE {
namespace {

HWY_INLINE std::uint32_t first_of(GroupBits groups) { return static_cast<std::uint32_t>(std::countr_zero(groups)); }

// How a packet goes through the tree.
struct Way {
  std::uint32_t octant;    // of most rays
  std::uint32_t mixed;     // bit a: not all rays go the way of the octant along axis a
  std::uint32_t reversal;  // 0, or 7: children from the far end on
};

HWY_INLINE Way way_of(const Packet& p, std::uint32_t octant, bool from_far_end) {
  Way way{octant, 0, from_far_end ? kBvh8Arity - 1 : 0};
  for (std::uint32_t i = 0; i < p.lanes; i += width())
    for (int a = 0; a < 3; ++a) {
      const Mask backwards = hn::Lt(load(p.inv[a] + i), set(0));
      const bool is_octant = (octant >> a & 1u) != 0 ? hn::AllTrue(kFloats, backwards) : hn::AllFalse(kFloats, backwards);
      way.mixed |= is_octant ? 0u : 1u << a;
    }
  return way;
}

// What all rays of a packet have in common.
enum class Share { nothing, way, way_and_origin };

// A child's planes, in all lanes: the ones that rays of the octant meet first, and last; relative to a shared origin.
template <Share kShare>
struct ChildPlanes {
  Floats near_plane[3], far_plane[3];

  HWY_INLINE ChildPlanes(const Packet& p, const Bvh8Node& node, std::uint32_t c, std::uint32_t octant) {
    for (int a = 0; a < 3; ++a) {
      const std::uint32_t side = octant >> a & 1u;
      near_plane[a] = set(node.plane(a, side, c)), far_plane[a] = set(node.plane(a, side ^ 1u, c));
      if constexpr (kShare == Share::way_and_origin) {
        near_plane[a] = hn::Sub(near_plane[a], set(p.origin[a])), far_plane[a] = hn::Sub(far_plane[a], set(p.origin[a]));
      }
    }
  }
};

// Bvh8Ray::enters(), of the rays from lane i on. Reciprocals for far planes are scaled each time: loads are dearer.
template <Share kShare>
HWY_INLINE Mask enter_child(const Packet& p, Way way, std::uint32_t i, const ChildPlanes<kShare>& child) {
  Floats nearer[3], farther[3];
  for (int a = 0; a < 3; ++a) {
    const Floats inv = load(p.inv[a] + i);
    Floats near_plane = child.near_plane[a], far_plane = child.far_plane[a];
    if (kShare == Share::nothing && (way.mixed >> a & 1u) != 0) {
      const Mask backwards = hn::Lt(inv, set(0)), is_octant = (way.octant >> a & 1u) != 0 ? backwards : hn::Not(backwards);
      near_plane = hn::IfThenElse(is_octant, child.near_plane[a], child.far_plane[a]);
      far_plane = hn::IfThenElse(is_octant, child.far_plane[a], child.near_plane[a]);
    }
    if constexpr (kShare != Share::way_and_origin) {
      const Floats org = load(p.org[a] + i);
      near_plane = hn::Sub(near_plane, org), far_plane = hn::Sub(far_plane, org);
    }
    nearer[a] = hn::Mul(near_plane, inv);
    farther[a] = hn::Mul(far_plane, hn::Mul(inv, set(PaddedSlabs::kFarPlaneScale)));
  }
  const Floats limit = hn::Mul(load(p.t + i), set(PaddedSlabs::kEndScale));
  const Floats enter = most(most(nearer[1], nearer[2]), most(nearer[0], load(p.t_min + i)));
  const Floats leave = least(least(farther[1], farther[2]), least(farther[0], limit));
  return hn::Le(enter, leave);
}

// The groups and, of each, the rays that are on their way, as bits.
struct Active {
  GroupBits groups;
  std::uint8_t rays[kMostGroups][8];

  HWY_INLINE static Active all(const Packet& p) {
    Active active;
    active.groups = 0;
    for (std::uint32_t g = 0; g < p.lanes / width(); ++g) {
      const Mask waiting = hn::Ge(load(p.t + g * width()), set(0));
      hn::StoreMaskBits(kFloats, waiting, active.rays[g]);
      active.groups |= static_cast<GroupBits>(!hn::AllFalse(kFloats, waiting)) << g;
    }
    return active;
  }
};

// A child, and the groups at its parent that may meet its box.
struct Postponed {
  NodeRef node;
  std::uint32_t child;
  GroupBits groups;
};

// Every ray of the groups that enters the child goes there. Returns false if there is none.
template <Share kShare>
HWY_INLINE bool enter(const Postponed& to, const Bvh8Node& node, const Packet& p, Way way, Active& active) {
  const ChildPlanes<kShare> child(p, node, to.child, way.octant);
  GroupBits groups = 0;
  for (GroupBits rest = to.groups; rest != 0; rest &= rest - 1) {
    const std::uint32_t g = first_of(rest);
    const Mask entered = enter_child(p, way, g * width(), child);
    hn::StoreMaskBits(kFloats, entered, active.rays[g]);
    groups |= static_cast<GroupBits>(!hn::AllFalse(kFloats, entered)) << g;
  }
  active.groups = groups;
  return groups != 0;
}

// Returns how many new answers there are.
template <Query kQuery, class Triangle>
HWY_INLINE std::uint32_t intersect_triangle(const Triangle& triangle, const Active& active, Packet& p) {
  std::uint32_t answered = 0;
  GroupTest<kQuery, Triangle> test(p, triangle);
  for (GroupBits rest = active.groups; rest != 0; rest &= rest - 1) {
    const std::uint32_t g = first_of(rest);
    answered += test.intersect(g * width(), hn::LoadMaskBits(kFloats, active.rays[g]));
  }
  return answered;
}

template <Query kQuery, Share kShare>
HWY_INLINE std::uint32_t intersect_block(const TriangleBlock& block, const Active& active, Packet& p) {
  std::uint32_t answered = 0;
  if constexpr (kShare == Share::way_and_origin) {
    const RelativeVertices vertices(block, p.origin);
    for (std::uint32_t lane = 0; lane < kBlockLanes && block.has(lane); ++lane)
      answered += intersect_triangle<kQuery>(RelativeTriangle{block, vertices, lane}, active, p);
  } else {
    for (std::uint32_t lane = 0; lane < kBlockLanes && block.has(lane); ++lane) {
      const PackedTriangle triangle = block.packed(lane);
      answered += intersect_triangle<kQuery>(LoneTriangle{triangle}, active, p);
    }
  }
  return answered;
}

template <Query kQuery, Share kShare>
HWY_INLINE std::uint32_t intersect_leaf(const TriangleBlock* blocks, NodeRef leaf, const Active& active, Packet& p) {
  std::uint32_t answered = 0;
  const TriangleBlock* block = blocks + first_block(leaf);
  const std::uint32_t count = counted_blocks(leaf);
  for (std::uint32_t b = 0; count != 0 ? b < count : block->has(0); ++b, ++block)
    answered += intersect_block<kQuery, kShare>(*block, active, p);
  return answered;
}

// Begins to fetch a node, or the first block of a leaf.
HWY_INLINE void fetch(const Bvh8View& view, NodeRef ref) {
  const char* const at = is_leaf(ref) ? reinterpret_cast<const char*>(view.blocks + first_block(ref))
                                      : reinterpret_cast<const char*>(view.nodes + ref);
  for (std::size_t line = 0; line < sizeof(Bvh8Node); line += 64) hwy::Prefetch(at + line);
}

// The leaf that has stopped most rays of the last packet, which may stop the next one's: they run beside them.
struct Occluder {
  NodeRef leaf = kNoNode;
  std::uint32_t stopped = 0;

  // Of fewer rays than a quarter, the tests cost what they save.
  HWY_INLINE bool is_promising(const Packet& p) const { return 4 * stopped >= p.size; }
};

// A packet on its way.
struct Flight {
  Packet packet;
  Frustum frustum;
  Pencil pencil;  // of Share::way_and_origin
  Way way;
  Share share;
  NodeRef ref;             // what comes next: a node or a leaf
  Active active;           // at `ref`
  std::uint32_t answered;  // rays
  std::size_t size;        // of the stack
  Postponed stack[bvh8_stack_size(kMostBvh8Depth)];

  HWY_INLINE Share shared() const {
    if (way.mixed != 0) return Share::nothing;
    return packet.has_one_origin ? Share::way_and_origin : Share::way;
  }
};

// Pushes the children of a node, the nearest last, and begins to fetch them.
template <Share kShare>
HWY_INLINE void push_children(const Bvh8View& view, Flight& f) {
  const Bvh8Node& node = view.nodes[f.ref];
  const GroupBits here = f.active.groups;
  ChildSlopes slopes;
  std::uint32_t met;
  if constexpr (kShare == Share::way_and_origin)
    met = f.pencil.project(node, slopes);
  else
    met = boxes_met(node, f.frustum);
  for (std::uint32_t rest = met; rest != 0; rest &= rest - 1) fetch(view, node.child[std::countr_zero(rest)]);
  std::size_t size = f.size;
  for (std::uint32_t i = 0; i < kBvh8Arity; ++i) {
    const std::uint32_t c = node.ordered(i ^ f.way.reversal, f.way.octant);
    if constexpr (kShare == Share::way_and_origin) {
      if ((met >> c & 1u) == 0) continue;
      const GroupBits groups = f.pencil.groups_that_meet(slopes, c, here);
      f.stack[size] = {f.ref, c, groups};
      size += groups != 0 ? 1 : 0;
    } else {
      f.stack[size] = {f.ref, c, here};
      size += met >> c & 1u;
    }
  }
  f.size = size;
}

// To where memory is waited for: the next node's children. Returns false at the end.
template <Query kQuery, Share kShare>
HWY_NOINLINE bool go_on(const Bvh8View& view, Flight& f, Occluder& occluder) {
  for (;;) {
    const bool is_node = !is_leaf(f.ref);
    if (is_node) {
      push_children<kShare>(view, f);
    } else {
      const std::uint32_t more = intersect_leaf<kQuery, kShare>(view.blocks, f.ref, f.active, f.packet);
      if constexpr (kQuery == Query::any) {
        if (more > occluder.stopped) occluder = {f.ref, more};
        f.answered += more;
        if (f.answered == f.packet.size) return false;
      }
    }
    const Bvh8Node* parent;
    do {
      if (f.size == 0) return false;
      parent = view.nodes + f.stack[--f.size].node;
    } while (!enter<kShare>(f.stack[f.size], *parent, f.packet, f.way, f.active));
    f.ref = parent->child[f.stack[f.size].child];
    if (is_node) return true;
  }
}

// Packets on their way at a time: while memory answers one, others go on. Few, for each has some 20 KB of rays. Of any-hit
// queries one, since the next one begins with the leaf that has stopped it.
template <Query kQuery>
constexpr std::uint32_t kPacketsInTurn = kQuery == Query::closest ? 4 : 1;

// The packets of a batch, by turns.
template <Query kQuery, class Answer>
class Flights {
 public:
  HWY_INLINE Flights(const Bvh8View& view, const LocalizedBatch& batch, const std::uint8_t* faces, bool from_far_end,
                     Answer* answers)
      : view_(view),
        batch_(batch),
        faces_(faces),
        bounds_(bounds_of_children(view.nodes[view.root])),
        from_far_end_(from_far_end),
        answers_(answers) {}

  HWY_INLINE void trace() {
    constexpr std::uint32_t kMost = kPacketsInTurn<kQuery>;
    const auto most = static_cast<std::uint32_t>(std::min<std::size_t>(kMost, batch_.count));
    const auto flights = std::make_unique_for_overwrite<Flight[]>(most);  // too large for some stacks
    std::uint32_t count = 0;
    while (count < most && begin(flights[count])) ++count;
    Flight* in_turn[kMost];
    for (std::uint32_t i = 0; i < count; ++i) in_turn[i] = &flights[i];
    while (count > 0)
      for (std::uint32_t i = 0; i < count;) {
        Flight& f = *in_turn[i];
        if (HWY_LIKELY(go_on(f))) {
          ++i;
        } else {
          store_answers(f.packet, answers_);
          if (!begin(f)) in_turn[i] = in_turn[--count];
        }
      }
  }

 private:
  // The batch's next packet that the occluder does not stop as a whole. Returns false if there is none.
  HWY_INLINE bool begin(Flight& f) {
    for (;;) {
      if (next_ == batch_.count) return false;
      const std::uint8_t face = load_next(f.packet);
      f.answered = kQuery == Query::any ? ask_occluder(f.packet) : 0;
      if (f.answered < f.packet.size) return begin(f, face), true;
      store_answers(f.packet, answers_);
    }
  }

  // The next packet, or part of a packet of more than kMostGroups. Returns its face.
  HWY_INLINE std::uint8_t load_next(Packet& p) {
    const std::uint32_t packet = batch_.active[next_], first = batch_.packets[packet] + taken_;
    const std::uint32_t left = batch_.packets[packet + 1] - first,
                        size = std::min({left, kMostGroups * width(), kMaxPacketSize});
    taken_ = size < left ? taken_ + size : 0, next_ += size < left ? 0 : 1;
    load_rays(batch_.rays, batch_.ids + first, size, faces_[first] >> 1, p);
    if constexpr (kQuery == Query::any) p.reach = reach_of(p, bounds_);
    return faces_[first];
  }

  // Returns how many rays it stops. The packet's own best leaf takes its place.
  HWY_INLINE std::uint32_t ask_occluder(Packet& p) {
    if (!occluder_.is_promising(p)) return occluder_.stopped = 0;
    const Active all = Active::all(p);
    occluder_.stopped = p.has_one_origin ? intersect_leaf<kQuery, Share::way_and_origin>(view_.blocks, occluder_.leaf, all, p)
                                         : intersect_leaf<kQuery, Share::nothing>(view_.blocks, occluder_.leaf, all, p);
    return occluder_.stopped;
  }

  HWY_INLINE void begin(Flight& f, std::uint8_t face) {
    f.frustum = frustum_of(f.packet, face, bounds_);
    f.way = way_of(f.packet, f.frustum.signs, from_far_end_);
    f.share = f.shared();
    if (f.share == Share::way_and_origin) f.pencil.begin(f.packet, f.frustum);
    f.ref = view_.root, f.active = Active::all(f.packet), f.size = 0;
  }

  HWY_INLINE bool go_on(Flight& f) {
    switch (f.share) {
      case Share::nothing:
        return HWY_NAMESPACE::go_on<kQuery, Share::nothing>(view_, f, occluder_);
      case Share::way:
        return HWY_NAMESPACE::go_on<kQuery, Share::way>(view_, f, occluder_);
      default:
        return HWY_NAMESPACE::go_on<kQuery, Share::way_and_origin>(view_, f, occluder_);
    }
  }

  const Bvh8View& view_;
  const LocalizedBatch& batch_;
  const std::uint8_t* faces_;
  Aabb bounds_;
  bool from_far_end_;
  Answer* answers_;
  std::size_t next_ = 0;     // of the batch's active packets
  std::uint32_t taken_ = 0;  // of its rays
  Occluder occluder_;
};

template <Query kQuery, class Answer>
HWY_INLINE void trace_packets(const Bvh8View& view, const LocalizedBatch& batch, const std::uint8_t* faces, bool from_far_end,
                              Answer* answers) {
  Flights<kQuery, Answer>(view, batch, faces, from_far_end, answers).trace();
}

void intersect(const Bvh8View& view, const LocalizedBatch& batch, const std::uint8_t* faces, Hit* hits) {
  trace_packets<Query::closest>(view, batch, faces, false, hits);
}
void occlude(const Bvh8View& view, const LocalizedBatch& batch, const std::uint8_t* faces, bool from_far_end,
             std::uint8_t* occluded) {
  trace_packets<Query::any>(view, batch, faces, from_far_end, occluded);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace accel
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace accel {
HWY_EXPORT(intersect);
HWY_EXPORT(occlude);

void trace_bvh8_packets_simd(const Bvh8View& view, const LocalizedBatch& batch, const std::uint8_t* faces, Hit* hits) {
  HWY_DYNAMIC_DISPATCH(intersect)(view, batch, faces, hits);
}
void trace_bvh8_packets_simd(const Bvh8View& view, const LocalizedBatch& batch, const std::uint8_t* faces,
                             std::uint8_t* occluded, bool from_far_end) {
  HWY_DYNAMIC_DISPATCH(occlude)(view, batch, faces, from_far_end, occluded);
}
}  // namespace accel
#endif
