// The eight-wide bounding-volume hierarchy: what a CPU tests with one stream of instructions.
//
// Wald, Benthin and Boulos 2008, "Getting Rid of Packets: Efficient SIMD Single-Ray Traversal using Multi-Branching BVHs";
// Ernst and Greiner 2008, "Multi Bounding Volume Hierarchies". A node has the boxes of its children, by plane, so that a ray
// tests all eight at once; leaves are runs of triangle blocks (structure/triangle_block.h), of which four triangles are tested
// at once.
//
// Order. Which child comes first depends on the ray; a node has the answer for each octant of directions, so that traversal
// sorts nothing: it moves the children into that order and keeps those that are hit (trace/bvh8_ordered.h).
//
// Places without a child have an inverted box, which no ray enters, and come after all others.
//
// Node layouts. A structure has nodes of one layout: planes in single precision (Bvh8Node), or in few bits relative to the node
// (structure/bvh8_coded.h). What a layout has is what Bvh8Node has: plane(), is_absent(), child, order, the constants, and the
// kind of the leaves' blocks: TriangleBlock, or IndexedBlock (structure/indexed_block.h), which vertices come with.
//
// Invariants: every inner node but the root is the child of exactly one node; every block belongs to exactly one leaf, and
// leaves follow each other without gaps; depth is the largest number of inner nodes on a path; each octant's order is a
// permutation; a child's box contains the boxes of that child's children as they were before they were coded, and the parts of
// its triangles that the child stands for (a spatial split may give a triangle to several leaves). Builders keep them;
// validate() proves all but the last, and of coded boxes the last two, which a traversal needs to find its hits but not to be
// safe.
#pragma once

#include <cstdint>
#include <limits>
#include <type_traits>

#include "libaccel/core/aabb.h"
#include "libaccel/structure/arrays.h"
#include "libaccel/structure/indexed_block.h"
#include "libaccel/structure/node_hash.h"
#include "libaccel/structure/triangle_block.h"

namespace accel {

inline constexpr std::uint32_t kBvh8Arity = 8;

// A reference is a node by index, kNoNode, or, with the leaf bit set, a leaf: its first block, and how many it has. Leaves of
// more than kMostCounted blocks have no count and end in a block of their own, which is empty.
inline constexpr std::uint32_t kBlockBits = 28, kMostCounted = 6;
inline constexpr std::uint32_t kMaxBlocks = 1u << kBlockBits;
ACCEL_HD std::uint32_t first_block(NodeRef leaf) { return leaf & (kMaxBlocks - 1); }
ACCEL_HD std::uint32_t counted_blocks(NodeRef leaf) { return (leaf & ~kLeafBit) >> kBlockBits; }  // 0: until an empty one
ACCEL_HD NodeRef block_ref(std::uint32_t first, std::uint32_t count) {
  return kLeafBit | (count <= kMostCounted ? count : 0u) << kBlockBits | first;
}

// The child that comes as number i for an octant.
template <class Node>
ACCEL_HD std::uint32_t ordered_child(const Node& node, std::uint32_t i, std::uint32_t octant) {
  return node.order[i] >> 3 * octant & 7u;
}
template <class Node>
ACCEL_HD Aabb child_bounds(const Node& node, std::uint32_t c) {
  return {{node.plane(0, 0, c), node.plane(1, 0, c), node.plane(2, 0, c)},
          {node.plane(0, 1, c), node.plane(1, 1, c), node.plane(2, 1, c)}};
}

// The box around all children.
template <class Node>
ACCEL_HD Aabb bounds_of_children(const Node& node) {
  Aabb bounds;
  for (std::uint32_t c = 0; c < kBvh8Arity && node.child[c] != kNoNode; ++c) bounds.extend(node.bounds(c));
  return bounds;
}

struct alignas(64) Bvh8Node {
  using Block = TriangleBlock;
  static constexpr const char* kKind = "bvh8";  // of the structure
  static constexpr bool kIsExact = true;        // boxes are as they were built, so that children's lie in their parents'
  static constexpr bool kAbsentAreFar = true;   // boxes of absent children are infinite: no need to look whether there is one

  float planes[3][2][kBvh8Arity];   // per axis: lower planes of the children, and upper ones
  NodeRef child[kBvh8Arity];        // those there are come first; kNoNode behind them
  std::uint32_t order[kBvh8Arity];  // bits 3 o to 3 o + 2 of word i: the child that comes as number i for octant o

  // The lower (0) or upper (1) plane of a child.
  ACCEL_HD float plane(int axis, std::uint32_t side, std::uint32_t c) const { return planes[axis][side][c]; }
  ACCEL_HD Aabb bounds(std::uint32_t c) const { return child_bounds(*this, c); }
  ACCEL_HD std::uint32_t ordered(std::uint32_t i, std::uint32_t octant) const { return ordered_child(*this, i, octant); }
  ACCEL_HD bool is_absent(std::uint32_t c) const {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    for (int a = 0; a < 3; ++a)
      if (!(planes[a][0][c] == kInfinity && planes[a][1][c] == -kInfinity)) return false;
    return true;
  }

  void set_child(std::uint32_t c, NodeRef ref, const Aabb& box) {
    child[c] = ref;
    for (int a = 0; a < 3; ++a) planes[a][0][c] = box.lo[a], planes[a][1][c] = box.hi[a];
  }
};
static_assert(sizeof(Bvh8Node) == 256 && std::is_trivially_copyable_v<Bvh8Node>);

template <class Node>
struct Bvh8ViewOf {
  using Block = typename Node::Block;

  const Node* nodes = nullptr;
  const Block* blocks = nullptr;
  NodeRef root = kNoNode;  // kNoNode: an empty scene
  std::uint32_t depth = 0;
  const Vec3* vertices = nullptr;  // of indexed blocks

  ACCEL_HD PackedTriangle packed(const Block& block, std::uint32_t lane) const {
    if constexpr (Block::kIsIndexed)
      return block.packed(lane, vertices);
    else
      return block.packed(lane);
  }
};

// What of a Bvh8 is no array.
struct Bvh8Words {
  NodeRef root = kNoNode;
  std::uint32_t depth = 0;       // inner nodes on the longest path from the root
  std::uint64_t references = 0;  // triangles in the leaves, with repetitions
  Aabb bounds;                   // of the whole tree
};
static_assert(sizeof(Bvh8Words) == 40 && std::is_trivially_copyable_v<Bvh8Words>);

// The owning structure.
template <class NodeType>
struct Bvh8Of : Bvh8Words {
  static constexpr const char* kName = NodeType::kKind;
  using Node = NodeType;
  using Block = typename Node::Block;
  using View = Bvh8ViewOf<Node>;
  using Words = Bvh8Words;

  Buffer<Node> nodes;
  Buffer<Block> blocks;
  Buffer<Vec3> vertices;  // of indexed blocks; others have none

  template <class Self, class Visit>
  static void for_each_array(Self& self, Visit&& visit) {
    visit("nodes", self.nodes);
    visit("blocks", self.blocks);
    if constexpr (Block::kIsIndexed) visit("vertices", self.vertices);
  }
  std::size_t size_bytes() const { return bytes_of_arrays(*this); }
  View view() const { return {nodes.data(), blocks.data(), root, depth, vertices.data()}; }
};

using Bvh8 = Bvh8Of<Bvh8Node>;
using Bvh8View = Bvh8::View;

// The blocks of a leaf of a valid tree.
template <class Block>
std::uint32_t block_count(const Buffer<Block>& blocks, NodeRef leaf) {
  std::uint32_t count = counted_blocks(leaf);
  if (count == 0)
    while (blocks[first_block(leaf) + count].has(0)) ++count;
  return count;
}

// Proves every invariant that traversal relies on, whatever the bytes are.
template <class Node>
Status validate(const Bvh8Of<Node>& bvh, std::uint64_t triangle_count);

}  // namespace accel
