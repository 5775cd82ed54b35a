// Visits all nodes of a kd-tree from the root down, with what each inherits: the loop of the annotation passes.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include <tbb/parallel_invoke.h>

#include "libaccel/structure/kdtree.h"

namespace accel {

// The parts of a cell below (side 0) and above (side 1) a plane.
inline Aabb part_of(Aabb cell, KdNode node, std::uint32_t side) {
  (side == 0 ? cell.hi : cell.lo)[node.axis()] = node.plane();
  return cell;
}

template <class Inherited, class Visit, class Inherit>
void walk_subtree(const KdTree& tree, std::uint32_t root, const Inherited& inherited_by_root, const Visit& visit,
                  const Inherit& inherit) {
  std::vector<std::pair<std::uint32_t, Inherited>> pending{{root, inherited_by_root}};
  while (!pending.empty()) {
    auto [index, inherited] = pending.back();
    pending.pop_back();
    visit(index, inherited);
    const KdNode node = tree.nodes[index];
    if (node.is_leaf()) continue;
    for (const std::uint32_t side : {1u, 0u}) pending.emplace_back(node.lower_child() + side, inherit(index, inherited, side));
  }
}

// Levels of the tree whose two subtrees are visited concurrently: some thousand tasks.
inline constexpr int kParallelLevels = 10;

// visit(index, inherited) is called for each node, after its parent, and may change what its children inherit;
// inherit(index, inherited, side) gives what the child on a side inherits. Subtrees are visited concurrently. Recursive no
// further than that: a tree from a file may be as deep as it has nodes.
template <class Inherited, class Visit, class Inherit>
void walk_kdtree(const KdTree& tree, std::uint32_t index, Inherited inherited, const Visit& visit, const Inherit& inherit,
                 int level = 0) {
  if (level == kParallelLevels) return walk_subtree(tree, index, inherited, visit, inherit);
  visit(index, inherited);
  const KdNode node = tree.nodes[index];
  if (node.is_leaf()) return;
  const auto walk_child = [&](std::uint32_t side) {
    walk_kdtree(tree, node.lower_child() + side, inherit(index, inherited, side), visit, inherit, level + 1);
  };
  tbb::parallel_invoke([&] { walk_child(0); }, [&] { walk_child(1); });
}

}  // namespace accel
