// The Octo-BVH: a Bvh2 with up to eight children a node, which packets of rays traverse.
//
// Garanzha and Loop 2010, "Fast Ray Sorting and Breadth-First Packet Traversal for GPU Ray Tracing" [GL10], section 3.3. Nodes
// are stored breadth first, and leaves are those of the Bvh2. Children are in spatial order: bit a of a child's place is set if
// it lies on the upper side of axis a, so that `i xor signs`, with the bits of negative axes of a direction, names the children
// from front to back. The order is approximate, since eight children need not lie in eight octants.
//
// Deviations. [GL10] keeps a node's own box in its 32 bytes; here a node has the boxes of its children, axis by axis, in the
// same 32 bytes a child, so that all eight are tested at once. References have 32 bits instead of 24, and places without a
// child are kept, since the order needs all eight. [GL10] removes two levels of three; here the child with the largest surface
// is opened until there are eight, which leaves fewer places empty.
#pragma once

#include <cstdint>
#include <limits>
#include <type_traits>

#include "libaccel/core/aabb.h"
#include "libaccel/structure/node_hash.h"

namespace accel {

inline constexpr std::uint32_t kOctoArity = 8;

struct alignas(64) OctoNode {
  float lower[3][kOctoArity], upper[3][kOctoArity];  // of the children, by axis; inverted and infinite where there is none
  NodeRef child[kOctoArity];                         // an octo node, a leaf, or kNoNode
  std::uint32_t child_mask;                          // bit c: there is a child c
  std::uint32_t leaf_mask;                           // bit c: child c is a leaf or none
  std::uint32_t unused[6];                           // zero

  ACCEL_HD Aabb bounds(std::uint32_t c) const {
    return {{lower[0][c], lower[1][c], lower[2][c]}, {upper[0][c], upper[1][c], upper[2][c]}};
  }
  void set_child(std::uint32_t c, NodeRef ref, const Aabb& box) {
    child[c] = ref;
    child_mask = (child_mask & ~(1u << c)) | (ref == kNoNode ? 0u : 1u) << c;
    leaf_mask = (leaf_mask & ~(1u << c)) | (is_leaf(ref) ? 1u : 0u) << c;
    for (int a = 0; a < 3; ++a) lower[a][c] = box.lo[a], upper[a][c] = box.hi[a];
  }
  void clear() {
    *this = {};
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    for (std::uint32_t c = 0; c < kOctoArity; ++c)
      set_child(c, kNoNode, {{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}});
  }
};
static_assert(sizeof(OctoNode) == 256 && std::is_trivially_copyable_v<OctoNode>);

// A child of a node by its place in the array of all children, where its box is, too. With the leaf bit set, it is a leaf.
inline constexpr std::uint32_t kMaxOctoNodes = kLeafBit / kOctoArity;

}  // namespace accel
