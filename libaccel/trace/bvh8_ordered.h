// Ordered traversal of a Bvh8, of any node layout, with a stack.
//
// All children's boxes are tested at their parent. Those that the ray enters go onto the stack in the node's order for the
// octant of the ray's direction, the nearest last, each with its entry distance, so that it can be dropped unread when a nearer
// hit has been found meanwhile. The box test is that of trace/bvh8_ray.h.
//
// Why an order by octant. Sorting by distance visits fewer nodes, but few; what it costs a CPU is branches that nobody
// predicts.
//
// On CPUs batches are traced by trace/bvh8_simd.h, the same steps with eight boxes or four triangles at once: this is its
// scalar twin, which names the same hits bit for bit, and what counters, models of machines, multi-hit queries and devices run.
#pragma once

#include "libaccel/structure/bvh8_coded.h"
#include "libaccel/trace/bvh8_ray.h"
#include "libaccel/trace/bvh8_simd.h"
#include "libaccel/trace/simd_batch.h"
#include "libaccel/trace/traverser.h"

namespace accel {

template <class Node, class Slabs, class Test, Query kQuery, class TraceSingly>
using Bvh8Batch = SimdBatch<Bvh8ViewOf<Node>, Bvh8Simd<Node, Slabs, Test>, kQuery, TraceSingly>;

template <class Node, class Slabs, class Test, Query kQuery, std::uint32_t kDepth>
struct Bvh8OrderedWithin {
  static constexpr const char* kName = "ordered";
  static constexpr bool kIsRobust = Slabs::kIsRobust;
  using View = Bvh8ViewOf<Node>;
  static constexpr std::uint32_t kMaxDepth = kDepth;

  struct Postponed {
    NodeRef node;
    float t_near;
  };
  struct Stack {
    Postponed entries[bvh8_stack_size(kDepth)];
  };
  struct State {
    Bvh8Ray<Slabs> boxes;
    typename Test::RayData test;
    NodeRef node;               // while descending
    std::uint32_t block, lane;  // in a leaf: the triangle that comes next
    std::uint32_t left;         // blocks of the leaf from there on, or 0: until an empty one
    int postponed;              // entries on the stack
    Stack* stack;
  };

  // For instances: see trace/two_level.h. In the tree over them, `block` is the number of one.
  ACCEL_HD static std::uint32_t& leaf(State& state) { return state.block; }
  ACCEL_HD static Phase end_leaf(const View&, State&, const Hit&) { return Phase::backtrack; }

  template <class Observer>
  ACCEL_HD static Phase begin(const View& view, const Ray& ray, State& state, Hit& hit, Observer& observer) {
    begin_hit(ray, hit);
    if (view.root == kNoNode || !is_traceable(ray)) return Phase::done;
    state.boxes = Bvh8Ray<Slabs>::prepare(ray, first_t(ray));
    state.test = Test::prepare(ray);
    state.postponed = 0;
    return enter(state, view.root, observer);
  }

  template <class Observer>
  ACCEL_HD static Phase descend(const View& view, const Ray&, State& state, Hit& hit, Observer& observer) {
    const Node& node = view.nodes[state.node];
    observer.node_step();
    observer.load(Memory::node, &node, sizeof node);
    observer.box_tests(kBvh8Arity);
    const float limit = scaled_end<Slabs>(hit.t);
    for (std::uint32_t i = 0; i < kBvh8Arity; ++i) {
      const std::uint32_t c = node.ordered(i, state.boxes.octant);
      float t_near;
      if (!state.boxes.enters(node, c, limit, t_near)) continue;
      Postponed& entry = state.stack->entries[state.postponed++];
      observer.store(Memory::stack, &entry, sizeof entry);
      entry = {node.child[c], t_near};
    }
    return Phase::backtrack;
  }

  template <class Observer>
  ACCEL_HD static Phase intersect(const View& view, const Ray& ray, State& s, Hit& hit, Observer& observer) {
    const auto& block = view.blocks[s.block];
    tell_loads(view, block, s.lane, observer);
    observer.triangle_test();
    Hit candidate;
    if (Test::intersect(view.packed(block, s.lane), ray, s.test, candidate)) {
      candidate.prim_id = block.prim_id[s.lane];
      if (accept_hit(candidate, s.boxes.t_min, hit) && kQuery == Query::any) return Phase::done;
    }
    if (++s.lane < kBlockLanes && block.has(s.lane)) return Phase::intersect;
    ++s.block, s.lane = 0;
    if (s.left == 0) return view.blocks[s.block].has(0) ? Phase::intersect : Phase::backtrack;
    return --s.left == 0 ? Phase::backtrack : Phase::intersect;
  }

  template <class Observer>
  ACCEL_HD static Phase backtrack(const View&, const Ray&, State& state, [[maybe_unused]] Hit& hit, Observer& observer) {
    if (state.postponed == 0) return Phase::done;
    observer.backtrack();
    const Postponed& entry = state.stack->entries[--state.postponed];
    observer.load(Memory::stack, &entry, sizeof entry);
    return entry.t_near <= scaled_end<Slabs>(hit.t) ? enter(state, entry.node, observer) : Phase::backtrack;
  }

 private:
  // Blocks are fetched whole, vertices one by one.
  template <class Observer>
  ACCEL_HD static void tell_loads(const View& view, const typename View::Block& block, std::uint32_t lane, Observer& observer) {
    if (lane == 0) observer.load(Memory::triangle, &block, sizeof block);
    if constexpr (View::Block::kIsIndexed)
      for (const auto& vertex : block.vertex) observer.load(Memory::triangle, view.vertices + vertex[lane], sizeof(Vec3));
  }

  template <class Observer>
  ACCEL_HD static Phase enter(State& state, NodeRef node, Observer& observer) {
    if (!is_leaf(node)) {
      state.node = node;
      return Phase::descend;
    }
    state.block = first_block(node), state.lane = 0, state.left = counted_blocks(node);
    observer.leaf_visit(state.block);
    return Phase::intersect;
  }
};

// Trees of this depth have billions of triangles, unless they are degenerate: less memory for each ray of a device.
inline constexpr std::uint32_t kShallowBvh8 = 24;

template <class Node, class Slabs, class Test, Query kQuery>
struct ShallowBvh8Ordered : Bvh8OrderedWithin<Node, Slabs, Test, kQuery, kShallowBvh8> {
  static constexpr bool kForDevices = true;
};

template <class Node, class Slabs, class Test, Query kQuery>
struct Bvh8OrderedWith : Bvh8OrderedWithin<Node, Slabs, Test, kQuery, kMostBvh8Depth> {
  using Specialisations = TypeList<ShallowBvh8Ordered<Node, Slabs, Test, kQuery>>;

  template <class TraceSingly>
  using Batch = Bvh8Batch<Node, Slabs, Test, kQuery, TraceSingly>;
};

template <class Test, Query kQuery>
struct Bvh8Ordered : Bvh8OrderedWith<Bvh8Node, PaddedSlabs, Test, kQuery> {};

// With box tests that are known to lose hits, to be compared.
template <class Test, Query kQuery>
struct Bvh8OrderedNaive : Bvh8OrderedWith<Bvh8Node, NaiveSlabs, Test, kQuery> {
  static constexpr const char* kName = "ordered-naive";
};
template <class Test, Query kQuery>
struct Bvh8OrderedFused : Bvh8OrderedWith<Bvh8Node, FusedSlabs, Test, kQuery> {
  static constexpr const char* kName = "ordered-fma";
};

// Over coded boxes.
template <class Test, Query kQuery>
struct Bvh8ByteOrdered : Bvh8OrderedWith<ByteBvh8Node, PaddedSlabs, Test, kQuery> {};
template <class Test, Query kQuery>
struct Bvh8HalfOrdered : Bvh8OrderedWith<HalfBvh8Node, PaddedSlabs, Test, kQuery> {};

// And with leaves that name vertices.
template <class Test, Query kQuery>
struct Bvh8CompactOrdered : Bvh8OrderedWith<CompactBvh8Node, PaddedSlabs, Test, kQuery> {};

}  // namespace accel
