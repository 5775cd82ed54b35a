// A binary tree that subtrees can be moved about in: what reinsertion (build/reinsertion.h) works on.
//
// The nodes are those of structure/bvh2.h, and their boxes are tight: each is the union of the two boxes in its node, so that a
// change goes up no further than to the first box that stays as it is. Leaves are numbered, and their boxes and triangles stay
// what the builder made them: after spatial splits a leaf's box is smaller than its triangles.
//
// A place in the tree is a slot: a side of a node, or the root's. Moving a subtree frees its parent node, which becomes the new
// parent at the target. So nodes and leaves keep their names, whatever moves.
//
// 16 bytes an inner node beside the structure; for the end, the structure once more.
#pragma once

#include <cstdint>
#include <vector>

#include "libaccel/structure/bvh2.h"

namespace accel {

class ReinsertionTree {
 public:
  using Slot = std::uint32_t;  // 2 * node + side
  static constexpr Slot kRootSlot = 0xffffffffu;

  // Takes the nodes; the leaf stream stays where it is, and give_back() needs it. The tree has an inner node, and parents come
  // before their children, as builders emit them. No path gets more than `most_levels` inner nodes, or than the longest has.
  ReinsertionTree(Bvh2& bvh, std::uint32_t most_levels);
  // Makes it the structure's again, nodes and leaves in the order of build/emit_bvh2.h: depth first, the larger child first.
  void give_back(Bvh2& bvh);

  std::uint32_t node_count() const { return static_cast<std::uint32_t>(nodes_.size()); }
  const Bvh2Node& node(NodeRef inner) const { return nodes_[inner]; }
  Slot slot_of(NodeRef ref) const { return slots_[is_leaf(ref) ? node_count() + leaf_quad(ref) : ref]; }
  NodeRef ref_at(Slot slot) const { return slot == kRootSlot ? root_ : nodes_[slot / 2].child[slot % 2]; }
  NodeRef sibling_of(NodeRef ref) const { return ref_at(slot_of(ref) ^ 1u); }  // not of the root
  Aabb box_at(Slot slot) const { return slot == kRootSlot ? root_box_ : nodes_[slot / 2].bounds(static_cast<int>(slot % 2)); }

  // Half the areas of all inner nodes, as they are and as they came; and of leaves, times their triangles.
  double inner_area() const { return inner_area_; }
  double inner_area_before() const { return inner_area_before_; }
  double leaf_area() const { return leaf_area_; }

  // Moves a subtree to where it becomes the sibling of `target`, if that makes the sum of areas smaller, keeps to the levels
  // and is a move at all: the target may be below it by now, or be its sibling or parent. Returns whether it did.
  bool improve(NodeRef subtree, NodeRef target);

  // Beside the structure.
  std::size_t size_bytes() const { return (slots_.size() + quads_.size() + levels_.size()) * sizeof(std::uint32_t); }

 private:
  void number_leaves();
  void number_nodes();
  void tighten_boxes();
  void measure_levels();
  void measure_leaves(const Bvh2& bvh);
  bool may_move(NodeRef subtree, NodeRef target) const;
  double move(NodeRef subtree, NodeRef target);
  double tighten_above(Slot slot);
  void put(Slot slot, NodeRef ref, const Aabb& box);
  void raise_above(NodeRef inner);
  std::uint32_t levels(NodeRef ref) const { return is_leaf(ref) ? 0 : levels_[ref]; }

  Buffer<Bvh2Node> nodes_;
  NodeRef root_;
  Aabb root_box_;
  std::uint32_t most_levels_;
  std::vector<Slot> slots_;            // where inner nodes are, then leaves
  std::vector<std::uint32_t> quads_;   // of each leaf, in the leaf stream
  std::vector<std::uint32_t> levels_;  // of inner nodes from an inner node down, at most
  double inner_area_ = 0, inner_area_before_ = 0, leaf_area_ = 0;
};

}  // namespace accel
