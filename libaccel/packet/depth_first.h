// Depth-first traversal by frustums, one after the other, each with a stack: what Garanzha and Loop 2010 [GL10], section 5.5,
// compare breadth-first traversal with, and its twin (packet/breadth_first.h): the same leaves in the same order.
//
// Nothing bounds what a frustum may meet. Time and memory are O(nodes and leaves met).
#pragma once

#include <bit>
#include <cstdint>
#include <vector>

#include "libaccel/packet/culling_simd.h"
#include "libaccel/packet/frustum_trees.h"

namespace accel {

// Tell which children of a node a frustum meets: one at a time, and all in SIMD lanes.
template <class Tree>
struct ScalarChildren {
  static std::uint32_t met(const typename Tree::Node& node, const Frustum& frustum) {
    return children_met<Tree>(node, frustum);
  }
};
struct SimdChildren {
  static std::uint32_t met(const OctoNode& node, const Frustum& frustum) {
    const std::uint32_t first = 0;
    std::uint8_t mask = 0;
    cull_simd(&node, &frustum, &first, &first, 1, &mask);
    return mask;
  }
};

template <class Tree = OctoTree, class Children = SimdChildren>
class DepthFirst {
 public:
  // Pairs of frustums and places of leaves, as in FrustumQueue.
  struct Leaves {
    std::vector<std::uint32_t> frustum, place;
  };

  // The leaves that the frustums meet, all of one frustum one after the other, in the order of frustums. Valid until the next
  // call. view.octo_count > 0, for either tree. May throw std::bad_alloc.
  const Leaves& run(const Bvh2View& view, const Frustum* frustums, std::size_t count) {
    leaves_.frustum.clear(), leaves_.place.clear();
    for (std::size_t f = 0; f < count; ++f) {
      stack_.assign(1, Tree::root(view));
      while (!stack_.empty()) {
        const std::uint32_t place = stack_.back();
        stack_.pop_back();
        if (is_leaf(place))
          leaves_.frustum.push_back(static_cast<std::uint32_t>(f)), leaves_.place.push_back(place);
        else
          postpone_children(Tree::nodes(view)[place], place, frustums[f]);
      }
    }
    return leaves_;
  }

 private:
  // Puts the children that the frustum meets on the stack, the nearest last.
  void postpone_children(const typename Tree::Node& node, std::uint32_t place, const Frustum& frustum) {
    const std::uint32_t order = Tree::order(node, frustum.signs);
    std::uint32_t ranks = by_rank(Children::met(node, frustum), order);
    while (ranks != 0) {
      const auto rank = static_cast<std::uint32_t>(std::bit_width(ranks)) - 1, c = rank ^ order;
      stack_.push_back(is_leaf(node.child[c]) ? kLeafBit | (place * Tree::kArity + c) : node.child[c]);
      ranks ^= 1u << rank;
    }
  }

  std::vector<std::uint32_t> stack_;
  Leaves leaves_;
};

}  // namespace accel
