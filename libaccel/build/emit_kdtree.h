// From what the kd-tree builder leaves behind to a KdTree: places of nodes, leaves and references, and the triangles.
//
// As for BVHs (emit_bvh2.h) a builder makes upper nodes one by one, and treelets below them, each by one task into arrays of
// its own with positions relative to its start; positions in the tree hence do not depend on the tasks. Pairs of nodes and
// leaves are in depth-first order. Triangles are stored in the order in which leaves first name them, so that those of
// neighbouring leaves are neighbours; the references of a leaf are sorted by slot. O(n).
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "libaccel/build/build_context.h"
#include "libaccel/structure/kdtree.h"

namespace accel {

struct KdTreelet {
  Aabb cell;
  KdNode root{};                          // a leaf, or an inner node with children in `nodes`
  std::vector<KdNode> nodes;              // pairs; children and references are relative to the treelet's firsts
  std::vector<std::uint32_t> references;  // prim_ids of the leaves, the last one of each marked
  std::uint32_t leaves = 0;

  // Begins a leaf; all its prim_ids are added before anything else.
  KdNode add_leaf(std::size_t count) {
    return KdNode::leaf(count > 0 ? static_cast<std::uint32_t>(references.size()) : kEmptyLeaf, leaves++);
  }
  // Takes back what has been added since mark().
  struct Mark {
    std::size_t nodes, references;
    std::uint32_t leaves;
  };
  Mark mark() const { return {nodes.size(), references.size(), leaves}; }
  void take_back(const Mark& mark) { nodes.resize(mark.nodes), references.resize(mark.references), leaves = mark.leaves; }
  std::size_t size_bytes() const { return nodes.capacity() * sizeof(KdNode) + references.capacity() * sizeof(std::uint32_t); }
};

// An inner node with two children, or a treelet.
struct KdSubtree {
  std::unique_ptr<KdSubtree> child[2];
  int axis = 0;
  float position = 0;
  KdTreelet treelet;

  bool is_treelet() const { return child[0] == nullptr; }
};

// The finished structure; depth and bounds are the caller's to set. Fails when nodes or references outgrow 32-bit links.
Result<KdTree> emit_kdtree(BuildContext& context, const KdSubtree& tree);

}  // namespace accel
