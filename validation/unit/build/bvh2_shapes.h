// Binary trees that no builder makes, over the leaves of those that one made.
#pragma once

#include <algorithm>
#include <vector>

#include "libaccel/core/counter_rng.h"
#include "libaccel/structure/bvh2.h"

namespace accel::test {

struct BoxedLeaf {
  NodeRef ref;
  Aabb box;
};

// In depth-first order. The tree has an inner node.
inline std::vector<BoxedLeaf> boxed_leaves(const Bvh2& bvh) {
  std::vector<BoxedLeaf> leaves;
  std::vector<BoxedLeaf> pending{{bvh.root, bvh.bounds}};
  while (!pending.empty()) {
    const BoxedLeaf at = pending.back();
    pending.pop_back();
    if (is_leaf(at.ref)) {
      leaves.push_back(at);
      continue;
    }
    const Bvh2Node& node = bvh.nodes[at.ref];
    for (const int c : {1, 0}) pending.push_back({node.child[c], node.bounds(c)});
  }
  return leaves;
}

// The tree over leaves [begin, end), cut where `cut` says, given begin and end; nodes are appended. Returns its depth.
template <class Cut>
std::uint32_t append_tree(const std::vector<BoxedLeaf>& leaves, std::size_t begin, std::size_t end, const Cut& cut,
                          std::vector<Bvh2Node>& nodes, BoxedLeaf& tree) {
  if (end - begin == 1) return tree = leaves[begin], 0;
  const std::size_t index = nodes.size(), middle = cut(begin, end);
  nodes.emplace_back();
  BoxedLeaf child[2];
  const std::uint32_t depth[2] = {append_tree(leaves, begin, middle, cut, nodes, child[0]),
                                  append_tree(leaves, middle, end, cut, nodes, child[1])};
  tree = {static_cast<NodeRef>(index), child[0].box};
  tree.box.extend(child[1].box);
  nodes[index] = {};
  for (int c = 0; c < 2; ++c) nodes[index].set_bounds(c, child[c].box), nodes[index].child[c] = child[c].ref;
  return 1 + std::max(depth[0], depth[1]);
}

// The same leaves in another tree.
template <class Cut>
Bvh2 with_tree(const Bvh2& bvh, const std::vector<BoxedLeaf>& leaves, const Cut& cut) {
  Bvh2 result = bvh;
  std::vector<Bvh2Node> nodes;
  BoxedLeaf tree;
  result.depth = append_tree(leaves, 0, leaves.size(), cut, nodes, tree);
  result.root = tree.ref;
  result.nodes = Buffer<Bvh2Node>::copy_of(nodes);
  return result;
}

// Leaves in random order, halved: nearly the worst of the shallow trees.
inline Bvh2 shuffled(const Bvh2& bvh) {
  std::vector<BoxedLeaf> leaves = boxed_leaves(bvh);
  CounterRng rng(7, 0);
  for (std::size_t i = leaves.size(); i > 1; --i)
    std::swap(leaves[i - 1], leaves[rng.next_below(static_cast<std::uint32_t>(i))]);
  return with_tree(bvh, leaves, [](std::size_t begin, std::size_t end) { return begin + (end - begin) / 2; });
}

// One leaf after the other: the deepest tree.
inline Bvh2 chained(const Bvh2& bvh) {
  return with_tree(bvh, boxed_leaves(bvh), [](std::size_t begin, std::size_t) { return begin + 1; });
}

}  // namespace accel::test
