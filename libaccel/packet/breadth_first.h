// Breadth-first traversal of an Octo-BVH by frustums: Garanzha and Loop 2010 [GL10], section 3.3, Fig. 9.
//
// The queue holds pairs of a frustum and a node that it meets, frustum by frustum. In each pass every pair is replaced by pairs
// with the children that the frustum meets, from front to back; leaves stay as they are. Counts are scanned to allocate the
// next queue, so it has the size that it needs and nothing is ever dropped. What is left are the leaves that each frustum
// meets, approximately from front to back.
//
// The number of passes is the depth of the tree, or less where no frustum goes deeper. Memory is that of two queues.
//
// An addition. A frustum that is too wide to be worth it meets more than its budget of nodes and leaves; it leaves the queue
// and is reported, so that its rays are traced in another way.
//
// Tree is OctoTree, or BinaryTree to see what eight children gain (packet/frustum_trees.h).
#pragma once

#include <bit>
#include <cstdint>
#include <utility>

#include "libaccel/packet/frustum_trees.h"

namespace accel {

// Of arrays that grow and never shrink.
template <class Primitives, class T>
T* with_room(typename Primitives::template Array<T>& array, std::size_t n) {
  if (array.size() < n) array = typename Primitives::template Array<T>(n + n / 2);
  return array.data();
}

template <class Primitives>
struct FrustumQueue {
  template <class T>
  using Array = typename Primitives::template Array<T>;

  Array<std::uint32_t> frustum;
  Array<std::uint32_t> place;  // a node by index, or with kLeafBit a leaf, by its place among all children: kArity node + child
  std::size_t count = 0;

  void reserve(std::size_t n) {
    with_room<Primitives, std::uint32_t>(frustum, n), with_room<Primitives, std::uint32_t>(place, n);
  }
};

// Tells which children of its node each pair of the queue meets: bit c of masks[i] for child c. Not of leaves.
template <class Tree>
struct ScalarCullingOf {
  template <class Primitives>
  static void cull(const typename Tree::Node* nodes, const Frustum* frustums, const FrustumQueue<Primitives>& queue,
                   std::uint8_t* masks) {
    const std::uint32_t *const frustum = queue.frustum.data(), *const place = queue.place.data();
    Primitives::for_each(queue.count, [=] ACCEL_HD_LAMBDA(std::size_t i) {
      if (is_leaf(place[i])) return;
      masks[i] = static_cast<std::uint8_t>(children_met<Tree>(nodes[place[i]], frustums[frustum[i]]));
    });
  }
};
using ScalarCulling = ScalarCullingOf<OctoTree>;

template <class Primitives, class Culling = ScalarCulling, class Tree = OctoTree>
class BreadthFirst {
 public:
  using Queue = FrustumQueue<Primitives>;

  // The leaves that the frustums meet, all of one frustum one after the other, in the order of frustums. Valid until the next
  // call. view.octo_count > 0, for either tree. Frustum f may have at most budgets[f] pairs in the queue; gave_up[f] says
  // whether it had more.
  const Queue& run(const Bvh2View& view, const Frustum* frustums, std::size_t count, const std::uint32_t* budgets,
                   std::uint8_t* gave_up) {
    in_.reserve(count), in_.count = count;
    std::uint32_t *const frustum = in_.frustum.data(), *const place = in_.place.data();
    const NodeRef root = Tree::root(view);
    Primitives::for_each(count, [=] ACCEL_HD_LAMBDA(std::size_t i) {
      frustum[i] = static_cast<std::uint32_t>(i), place[i] = root;
      gave_up[i] = 0;
    });
    with_room<Primitives, std::uint32_t>(first_, count);
    while (pass(Tree::nodes(view), frustums, budgets, gave_up) > 0) {
    }
    return in_;
  }

  // The steps of run(). CUDA's lambdas need them, and what they work on, to be public.

  using Node = typename Tree::Node;
  template <class T>
  using Array = typename Primitives::template Array<T>;

  // What a pair is replaced by: pairs, and how many of them are of nodes.
  struct Counts {
    std::uint32_t pairs, nodes;

    ACCEL_HD Counts& operator+=(const Counts& other) { return pairs += other.pairs, nodes += other.nodes, *this; }
  };

  // Returns how many pairs of nodes there are now.
  std::size_t pass(const Node* nodes, const Frustum* frustums, const std::uint32_t* budgets, std::uint8_t* gave_up) {
    const std::size_t n = in_.count;
    std::uint8_t* const masks = with_room<Primitives, std::uint8_t>(masks_, n);
    Counts *const counts = with_room<Primitives, Counts>(counts_, n), *const offsets =
                                                                          with_room<Primitives, Counts>(offsets_, n);
    Culling::cull(nodes, frustums, in_, masks);

    const std::uint32_t *const frustum = in_.frustum.data(), *const place = in_.place.data();
    Primitives::for_each(n, [=] ACCEL_HD_LAMBDA(std::size_t i) {
      if (is_leaf(place[i])) {
        counts[i] = {1, 0};
        return;
      }
      const std::uint32_t met = masks[i], inner = met & ~Tree::leaves(nodes[place[i]]);
      counts[i] = {static_cast<std::uint32_t>(std::popcount(met)), static_cast<std::uint32_t>(std::popcount(inner))};
    });
    Counts total = Primitives::exclusive_scan(counts, n, offsets);
    if (give_up(offsets, total.pairs, budgets, gave_up)) {
      Primitives::for_each(n, [=] ACCEL_HD_LAMBDA(std::size_t i) {
        if (gave_up[frustum[i]] != 0) counts[i] = {0, 0};
      });
      total = Primitives::exclusive_scan(counts, n, offsets);
    }

    out_.reserve(total.pairs), out_.count = total.pairs;
    std::uint32_t *const to_frustum = out_.frustum.data(), *const to_place = out_.place.data();
    Primitives::for_each(n, [=] ACCEL_HD_LAMBDA(std::size_t i) {
      if (counts[i].pairs == 0) return;
      std::uint32_t at = offsets[i].pairs;
      if (is_leaf(place[i])) {
        to_frustum[at] = frustum[i], to_place[at] = place[i];
        return;
      }
      const Node& node = nodes[place[i]];
      const std::uint32_t order = Tree::order(node, frustums[frustum[i]].signs);
      for (std::uint32_t ranks = by_rank(masks[i], order); ranks != 0; ranks &= ranks - 1) {
        const std::uint32_t c = static_cast<std::uint32_t>(std::countr_zero(ranks)) ^ order;
        to_frustum[at] = frustum[i];
        to_place[at++] = is_leaf(node.child[c]) ? kLeafBit | (place[i] * Tree::kArity + c) : node.child[c];
      }
    });
    std::swap(in_, out_);
    return total.nodes;
  }

  // Marks the frustums whose part of the next queue is larger than their budgets. Returns how many there are.
  std::uint32_t give_up(const Counts* offsets, std::uint32_t total, const std::uint32_t* budgets, std::uint8_t* gave_up) {
    const std::size_t n = in_.count;
    const std::uint32_t* const frustum = in_.frustum.data();
    std::uint32_t *const first = first_.data(), *const marks = with_room<Primitives, std::uint32_t>(marks_, n);
    Primitives::for_each(n, [=] ACCEL_HD_LAMBDA(std::size_t i) {
      if (i == 0 || frustum[i - 1] != frustum[i]) first[frustum[i]] = offsets[i].pairs;
    });
    Primitives::for_each(n, [=] ACCEL_HD_LAMBDA(std::size_t i) {
      const bool is_last = i + 1 == n || frustum[i + 1] != frustum[i];
      const std::uint32_t end = i + 1 == n ? total : offsets[i + 1].pairs;
      marks[i] = is_last && end - first[frustum[i]] > budgets[frustum[i]] ? 1 : 0;
      if (marks[i] != 0) gave_up[frustum[i]] = 1;
    });
    return Primitives::exclusive_scan(marks, n, marks);
  }

 private:
  Queue in_, out_;
  Array<std::uint8_t> masks_;
  Array<Counts> counts_, offsets_;
  Array<std::uint32_t> first_, marks_;  // first_: by frustum, where its part of the next queue begins
};

}  // namespace accel
