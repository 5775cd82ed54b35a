// From what top-down builders leave behind to a Bvh2: node and leaf positions, and the leaf stream.
//
// A builder makes a tree of subtrees: upper nodes one by one, and below them treelets, each built by one task into arrays of
// its own with positions relative to its start. Emission adds up the treelets' sizes in depth-first order and moves every
// treelet to its place. Positions hence depend on the tree alone, not on the tasks that made it. Nodes and leaves are both in
// depth-first order, the larger child first, so that a path tends to stay within few pages. O(n).
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "libaccel/build/build_context.h"
#include "libaccel/build/references.h"
#include "libaccel/structure/bvh2.h"

namespace accel {

// A run of references that becomes a leaf.
struct LeafRun {
  std::uint32_t begin, count;
};

struct Treelet {
  std::vector<Bvh2Node> nodes;  // child references are relative to the treelet's first node and first quad
  std::vector<LeafRun> leaves;  // in the order of their quads
  std::uint32_t quads = 0;
  NodeRef root = kNoNode;

  NodeRef add_leaf(std::size_t begin, std::size_t count);
  std::size_t size_bytes() const { return nodes.capacity() * sizeof(Bvh2Node) + leaves.capacity() * sizeof(LeafRun); }
};

// An inner node with two children, or a treelet.
struct Subtree {
  std::unique_ptr<Subtree> child[2];
  Aabb bounds[2];
  Treelet treelet;

  bool is_treelet() const { return child[0] == nullptr; }
};

// The finished structure; `tree` is consumed. Depth and bounds are the caller's to set. Fails when references outgrow 31 bits.
Result<Bvh2> emit_bvh2(BuildContext& context, std::unique_ptr<Subtree> tree, Reference* references);

}  // namespace accel
