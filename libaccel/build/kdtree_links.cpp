#include "libaccel/build/kdtree_links.h"

#include "libaccel/build/kdtree_walk.h"

namespace accel {

void add_links(KdTree& tree) {
  if (tree.nodes.empty()) return;
  const std::size_t pairs = tree.nodes.size() / 2;
  Buffer<std::uint32_t> parents(pairs);
  Buffer<Aabb> cells(pairs);
  parents[pair_of(kKdRoot)] = kKdRoot, cells[pair_of(kKdRoot)] = tree.bounds;  // unused
  walk_kdtree(
      tree, kKdRoot, tree.bounds,
      [&](std::uint32_t index, const Aabb& cell) {
        const KdNode node = tree.nodes[index];
        if (node.is_leaf()) return;
        parents[pair_of(node.lower_child())] = index;
        cells[pair_of(node.lower_child())] = cell;
      },
      [&](std::uint32_t index, const Aabb& cell, std::uint32_t side) { return part_of(cell, tree.nodes[index], side); });
  tree.parents = parents, tree.cells = cells;
}

}  // namespace accel
