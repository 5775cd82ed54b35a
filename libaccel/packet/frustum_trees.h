// The trees that frustums traverse, behind one interface: the Octo-BVH of Garanzha and Loop 2010 [GL10], section 3.3, and the
// binary tree that it is made from, which [GL10] compares it with in section 5.5.
//
// Children are taken from front to back by their rank: rank r is child r ^ order. The octo tree's children are in spatial
// order, so its order is the frustum's signs. Those of the binary tree are as the builder left them: which one comes first is
// read from the axis along which the centres of their boxes are farthest apart.
#pragma once

#include <cstdint>

#include "libaccel/packet/frustum.h"
#include "libaccel/structure/bvh2.h"

namespace accel {

// A mask of up to eight children by rank: bit r of the result is bit r ^ order of the mask.
ACCEL_HD std::uint32_t by_rank(std::uint32_t mask, std::uint32_t order) {
  if ((order & 1u) != 0) mask = (mask & 0x55u) << 1 | (mask >> 1 & 0x55u);
  if ((order & 2u) != 0) mask = (mask & 0x33u) << 2 | (mask >> 2 & 0x33u);
  if ((order & 4u) != 0) mask = (mask & 0x0fu) << 4 | (mask >> 4 & 0x0fu);
  return mask;
}

struct OctoTree {
  using Node = OctoNode;
  static constexpr std::uint32_t kArity = kOctoArity;
  static const Node* nodes(const Bvh2View& view) { return view.octo; }
  static NodeRef root(const Bvh2View&) { return 0; }

  ACCEL_HD static std::uint32_t children(const Node& node) { return node.child_mask; }
  ACCEL_HD static std::uint32_t leaves(const Node& node) { return node.leaf_mask; }
  ACCEL_HD static std::uint32_t order(const Node&, std::uint32_t signs) { return signs; }
};

// Its root must be no leaf.
struct BinaryTree {
  using Node = Bvh2Node;
  static constexpr std::uint32_t kArity = 2;
  static const Node* nodes(const Bvh2View& view) { return view.nodes; }
  static NodeRef root(const Bvh2View& view) { return view.root; }

  ACCEL_HD static std::uint32_t children(const Node&) { return 3; }
  ACCEL_HD static std::uint32_t leaves(const Node& node) {
    return (is_leaf(node.child[0]) ? 1u : 0u) | (is_leaf(node.child[1]) ? 2u : 0u);
  }
  ACCEL_HD static std::uint32_t order(const Node& node, std::uint32_t signs) {
    float most = 0;
    bool is_reversed = false;
    for (std::uint32_t a = 0; a < 3; ++a) {
      const float* const p = node.planes[a];
      const float apart = (p[1] + p[3]) - (p[0] + p[2]), distance = apart < 0 ? -apart : apart;
      if (!(distance > most)) continue;
      most = distance, is_reversed = (apart < 0) != ((signs >> a & 1u) != 0);
    }
    return is_reversed ? 1 : 0;
  }
};

// Which children of a node a frustum meets: bit c for child c.
template <class Tree>
ACCEL_HD std::uint32_t children_met(const typename Tree::Node& node, const Frustum& frustum) {
  std::uint32_t mask = 0;
  for (std::uint32_t c = 0; c < Tree::kArity; ++c) mask |= (frustum.meets(node.bounds(static_cast<int>(c))) ? 1u : 0u) << c;
  return mask & Tree::children(node);
}

}  // namespace accel
