// The binary bounding-volume hierarchy in 64-byte nodes that hold the boxes of both children.
//
// Aila and Laine 2009, "Understanding the Efficiency of Ray Traversal on GPUs"; the padding and its uses are those of Binder
// and Keller 2016, "Efficient Stackless Hierarchy Traversal on GPUs with Backtracking in Constant Time", Fig. 4. Deviation: the
// planes of an axis are interleaved by child, so that one 8-byte load brings the near planes of both children.
//
// Invariants: every inner node but the root is the child of exactly one node; every leaf of the stream is referenced exactly
// once; depth is the largest number of inner nodes on a path; a child's box contains the parts of its triangles that the child
// stands for (a spatial split may give a triangle to several leaves). Builders keep them; validate() proves all but the last
// for files, which a traversal needs to find its hits but not to be safe.
#pragma once

#include <cstdint>

#include "libaccel/structure/arrays.h"
#include "libaccel/structure/triangle_leaf.h"

namespace accel {

// What a child slot or a root refers to: an inner node by index, or, with the top bit set, a leaf by its first quad.
using NodeRef = std::uint32_t;
inline constexpr NodeRef kLeafBit = 0x80000000u;
inline constexpr NodeRef kNoNode = 0xffffffffu;

ACCEL_HD bool is_leaf(NodeRef ref) { return (ref & kLeafBit) != 0; }
ACCEL_HD std::uint32_t leaf_quad(NodeRef ref) { return ref & ~kLeafBit; }
ACCEL_HD NodeRef leaf_ref(std::uint32_t quad) { return quad | kLeafBit; }

struct alignas(64) Bvh2Node {
  float planes[3][4];  // per axis: lower planes of children 0 and 1, upper planes of children 0 and 1
  NodeRef child[2];
  std::uint32_t link[2];  // nothing (zero), parent and sibling, or uncle and grand-uncle

  void set_bounds(int c, const Aabb& box) {
    for (int a = 0; a < 3; ++a) planes[a][c] = box.lo[a], planes[a][2 + c] = box.hi[a];
  }
  Aabb bounds(int c) const {
    return {{planes[0][c], planes[1][c], planes[2][c]}, {planes[0][2 + c], planes[1][2 + c], planes[2][2 + c]}};
  }
};
static_assert(sizeof(Bvh2Node) == 64 && std::is_trivially_copyable_v<Bvh2Node>);

// What a traverser needs, passed to kernels by value.
struct Bvh2View {
  const Bvh2Node* nodes = nullptr;
  const LeafQuad* leaves = nullptr;
  NodeRef root = kNoNode;  // kNoNode: an empty scene
};

// The most inner nodes on a path from the root that traversers with a stack accept: one postponed child per level. Builders
// keep to it by default.
inline constexpr int kBvh2StackSize = 128;

// What of a Bvh2 is no array.
struct Bvh2Words {
  NodeRef root = kNoNode;
  std::uint32_t depth = 0;       // inner nodes on the longest path from the root
  std::uint64_t references = 0;  // triangles in the leaves, with repetitions
  Aabb bounds;                   // of the whole tree
};
static_assert(sizeof(Bvh2Words) == 40 && std::is_trivially_copyable_v<Bvh2Words>);

// The owning structure.
struct Bvh2 : Bvh2Words {
  static constexpr const char* kName = "bvh2";
  using View = Bvh2View;
  using Words = Bvh2Words;

  Buffer<Bvh2Node> nodes;
  Buffer<LeafQuad> leaves;

  template <class Self, class Visit>
  static void for_each_array(Self& self, Visit&& visit) {
    visit("nodes", self.nodes);
    visit("leaves", self.leaves);
  }
  std::size_t size_bytes() const { return bytes_of_arrays(*this); }
  Bvh2View view() const { return {nodes.data(), leaves.data(), root}; }
};

// Proves every invariant that traversal relies on, whatever the bytes are: references in range, no node or leaf reached twice,
// none unreachable, every leaf terminated, ordered planes without NaN, prim_id < triangle_count, depth and counts as stated.
Status validate(const Bvh2& bvh, std::uint64_t triangle_count);

}  // namespace accel
