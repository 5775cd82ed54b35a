#include "libaccel/build/kdtree_ropes.h"

#include "libaccel/build/kdtree_walk.h"

namespace accel {
namespace {

// The smallest subtree of `rope` that holds all leaves behind a face of `cell`: the face across `axis` below it (side 0) or
// above it (side 1).
std::uint32_t lower_rope(const KdTree& tree, std::uint32_t rope, int axis, int side, const Aabb& cell) {
  if (rope == kNoRope) return rope;
  for (KdNode node = tree.nodes[rope]; !node.is_leaf(); node = tree.nodes[rope]) {
    const std::uint32_t lower = node.lower_child(), upper = lower + 1;
    if (node.axis() == axis)
      rope = side == 0 ? upper : lower;  // the child that touches the face
    else if (node.plane() >= cell.hi[node.axis()])
      rope = lower;
    else if (node.plane() <= cell.lo[node.axis()])
      rope = upper;
    else
      break;
  }
  return rope;
}

}  // namespace

void add_ropes(KdTree& tree) {
  if (tree.nodes.empty()) return;
  Buffer<LeafRopes> ropes(tree.leaf_count);
  const LeafRopes root{tree.bounds, {kNoRope, kNoRope, kNoRope, kNoRope, kNoRope, kNoRope}};
  walk_kdtree(
      tree, kKdRoot, root,
      [&](std::uint32_t index, LeafRopes& neighbours) {
        for (int face = 0; face < 6; ++face) {
          std::uint32_t& rope = neighbours.rope[face];
          rope = lower_rope(tree, rope, face % 3, face / 3, neighbours.cell);
        }
        const KdNode node = tree.nodes[index];
        if (node.is_leaf()) ropes[node.ordinal()] = neighbours;
      },
      [&](std::uint32_t index, const LeafRopes& neighbours, std::uint32_t side) {
        const KdNode node = tree.nodes[index];
        LeafRopes child = neighbours;
        child.cell = part_of(neighbours.cell, node, side);
        child.rope[node.axis() + (side == 0 ? 3 : 0)] = sibling_of(node.lower_child() + side);
        return child;
      });
  tree.ropes = ropes;
}

}  // namespace accel
