// Many rays through a Bvh8 by one thread, by turns: trace/bvh8_simd.h says why. The guard lets the header through once for each
// target that Highway compiles.
#if defined(ACCEL_BVH8_INTERLEAVED_SIMD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ACCEL_BVH8_INTERLEAVED_SIMD_INL_H
#undef ACCEL_BVH8_INTERLEAVED_SIMD_INL_H
#else
#define ACCEL_BVH8_INTERLEAVED_SIMD_INL_H
#endif

#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "libaccel/core/buffer.h"
#include "libaccel/trace/bvh8_node_simd-inl.h"
#include "libaccel/trace/bvh8_simd.h"

HWY_BEFORE_NAMESPACE();
namespace accel {
namespace HWY_NAMESPACE {
namespace {

// Rays on their way at a time. As many steps lie between two of a ray: enough for memory to answer, few enough for the rays to
// stay in the first-level cache. 16 to 48 are within 10 % of each other.
inline constexpr std::uint32_t kRaysInTurn = 24;

// Leaves of a count that no leaf has are the ends of trees: what is at the bottom of stacks, and instances. kNoNode looks like
// them.
inline constexpr NodeRef kEnd = kLeafBit | (kMostCounted + 1) << kBlockBits;
constexpr bool is_end(NodeRef ref) { return ref >= kEnd; }
static_assert(kEnd >> kBlockBits == kNoNode >> kBlockBits);

// A ray on its way.
template <class Test, class Slabs>
struct alignas(64) Flight {
  static constexpr bool kHasInstances = false;
  static constexpr NodeRef kBottom = kEnd;  // of the stack
  // Entries, the bottom's included.
  static constexpr std::size_t stack_size(std::uint32_t depth) { return 1 + bvh8_stack_size(depth); }

  RayBoxes<Slabs> boxes;
  NodeRef ref;       // what comes next
  std::size_t size;  // entries on the stack
  Postponed stack;
  float limit;  // the scaled end
  typename Test::RayData test;
  Hit hit;
  const Ray* ray;  // null: none yet

  HWY_INLINE const Ray* source() const { return ray; }  // the one of the batch

  // The stack of all rays to come.
  HWY_INLINE void begin_stack(Postponed all, NodeRef bottom) {
    stack = all;
    stack.node[0] = bottom, stack.t_near[0] = -std::numeric_limits<float>::infinity();
  }

  HWY_INLINE void begin(const Ray& r, const Slopes& slopes) {
    ray = &r, size = 1;
    begin_hit(r, hit);
    test = BlockTest<Test>::prepare(r);
    boxes = RayBoxes<Slabs>(r, slopes);
    limit = scaled_end<Slabs>(hit.t);
  }

  template <Query kQuery, class Node>
  HWY_INLINE NodeRef descend(const Bvh8ViewOf<Node>& view) {
    std::size_t pushed = size;
    push_children<kQuery>(view.nodes[ref], boxes, limit, stack, pushed);
    size = pushed - 1;
    return stack.node[size];
  }

  // The first block of a leaf, `triangles`; all blocks of one that has no count. What follows any-hit queries that have their
  // answer is the end.
  template <Query kQuery, class Node>
  HWY_INLINE NodeRef intersect(const Bvh8ViewOf<Node>& view, const TriangleBlock& triangles) {
    const float t = hit.t;
    const bool has_answer = HWY_LIKELY(counted_blocks(ref) != 0)
                                ? BlockTest<Test>::template intersect<kQuery>(triangles, *ray, test, boxes.t_min, hit)
                                : intersect_leaf<Test, kQuery>(view, ref, *ray, test, boxes.t_min, hit);
    if (kQuery == Query::any && has_answer) return stack.node[0];
    if (kQuery == Query::closest && hit.t < t) {
      limit = scaled_end<Slabs>(hit.t);
      drop_postponed();
    }
    const bool has_more = counted_blocks(ref) > 1;
    const NodeRef rest = ref - (1u << kBlockBits) + 1, below = stack.node[size - 1];
    size -= has_more ? 0 : 1;
    return has_more ? rest : below;
  }

  // Drops what is postponed beyond the new end, so that nothing need look at distances again.
  HWY_INLINE void drop_postponed() {
    const auto end = hn::Set(kBoxes, limit);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < size; i += hn::Lanes(kBoxes)) {
      const auto t_near = hn::LoadU(kBoxes, stack.t_near + i);
      const auto node = hn::LoadU(kRefs, stack.node + i);
      const auto keep = hn::And(hn::Le(t_near, end), hn::FirstN(kBoxes, size - i));
      hn::StoreU(hn::Compress(t_near, keep), kBoxes, stack.t_near + kept);
      hn::StoreU(hn::Compress(node, hn::RebindMask(kRefs, keep)), kRefs, stack.node + kept);
      kept += hn::CountTrue(kBoxes, keep);
    }
    size = kept;
  }
};

// F: what a ray on its way is, in a tree or in one of instances (trace/bvh8_instances_simd.cpp).
template <class F, Query kQuery, class View, class Answer>
void trace_interleaved(const View& view, const Ray* rays, std::size_t count, Answer* answers) {
  if (view.root == kNoNode) {
    for (std::size_t i = 0; i < count; ++i) store_answer(Hit{}, answers[i]);
    return;
  }
  F flights[kRaysInTurn];
  const std::size_t entries = F::stack_size(view.depth);
  Buffer<NodeRef> nodes(kRaysInTurn * entries);
  Buffer<float> distances(kRaysInTurn * entries);

  // Who waits for which step, and room for one that is written but not counted.
  F *at_node[kRaysInTurn + 1], *at_block[kRaysInTurn + 1], *at_end[kRaysInTurn + 1];
  std::uint32_t at_nodes = 0, at_blocks = 0, at_ends = 0;
  // Queues a ray for what comes next, and begins to fetch that. No branches: which step it is nobody can predict.
  const char* memory[3] = {reinterpret_cast<const char*>(view.nodes), reinterpret_cast<const char*>(view.blocks)};
  std::size_t bytes[3] = {sizeof *view.nodes, sizeof *view.blocks};
  if constexpr (F::kHasInstances) memory[2] = reinterpret_cast<const char*>(view.instances), bytes[2] = sizeof *view.instances;
  const auto queue = [&](F& f, NodeRef ref) HWY_ATTR {
    f.ref = ref;
    const std::uint32_t leaf = ref >> 31, end = is_end(ref) ? 1u : 0u;
    at_node[at_nodes] = &f, at_nodes += 1 - leaf;
    at_block[at_blocks] = &f, at_blocks += leaf - end;
    at_end[at_ends] = &f, at_ends += end;
    const std::uint32_t kind = F::kHasInstances ? leaf + end : leaf;
    const std::size_t place = F::kHasInstances && ref == F::kBottom ? 0 : first_block(ref);
    const char* next = memory[kind] + place * bytes[kind];
    for (std::size_t line = 0; line < std::max(bytes[0], bytes[1]); line += 64) hwy::Prefetch(next + line);
  };

  for (std::uint32_t i = 0; i < kRaysInTurn; ++i) {
    F& f = flights[i];
    f.ray = nullptr, f.begin_stack({nodes.data() + i * entries, distances.data() + i * entries}, F::kBottom);
    at_end[at_ends++] = &f;
  }
  TriangleBlock room[kRaysInTurn];
  for (std::size_t next = 0;;) {
    // In place, here and below: who goes on to a step of the same kind is queued before the next is read.
    //
    // Rays that have ended make room for the next ones; others change trees.
    const std::uint32_t ending = at_ends;
    at_ends = 0;
    for (std::uint32_t i = 0; i < ending; ++i) {
      F& f = *at_end[i];
      if (f.ray != nullptr) {
        if constexpr (F::kHasInstances)
          if (!f.is_through()) {
            queue(f, f.template change_trees<kQuery>(view));
            continue;
          }
        finish_hit(f.hit);
        store_answer(f.hit, answers[f.source() - rays]);
        f.ray = nullptr;
      }
      Slopes slopes{};
      for (; next < count && !slopes.prepare(rays[next]); ++next) store_answer(Hit{}, answers[next]);
      if (next == count) continue;
      f.begin(rays[next++], slopes);
      queue(f, view.root);
    }
    if (at_nodes + at_blocks + at_ends == 0) return;

    const std::uint32_t descending = at_nodes;
    at_nodes = 0;
    for (std::uint32_t i = 0; i < descending; ++i) {
      F& f = *at_node[i];
      queue(f, f.template descend<kQuery>(view));
    }
    // Leaves wait until there are many of them.
    if (2 * at_nodes > kRaysInTurn) continue;
    const std::uint32_t intersecting = at_blocks;
    at_blocks = 0;
    // All that blocks name is fetched first: a test has branches that nobody predicts, and what follows one of them waits.
    const auto block_of = [&](const F* f) HWY_ATTR -> const auto& { return view.blocks[first_block(f->ref)]; };
    for (std::uint32_t i = 0; i < intersecting; ++i) fetch_triangles(view, block_of(at_block[i]), room[i]);
    for (std::uint32_t i = 0; i < intersecting; ++i) {
      F& f = *at_block[i];
      queue(f, f.template intersect<kQuery>(view, fetched(block_of(&f), room[i])));
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace accel
HWY_AFTER_NAMESPACE();

#endif
