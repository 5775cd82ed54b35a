// The kd-tree in 8-byte nodes, with optional arrays that only some traversers read.
//
// Pharr and Humphreys 2004 (nodes of 64 bits); Foley and Sugerman 2005, "KD-Tree Acceleration Structures for a GPU Raytracer"
// [FS05], sections 3.1 and Fig. 5 (parent links and boxes as an extension); Popov et al. 2007, "Stackless KD-Tree Traversal for
// High Performance GPU Ray Tracing" (ropes). Deviations: the children of a node are adjacent, so it stores one index. A pair of
// children belongs to one inner node, so parents and boxes are stored once a pair. Leaves refer to shared triangles.
//
// Invariants. Node 0 is the root and node 1 is unused; every other node belongs to one pair (2 i, 2 i + 1), and every pair to
// one inner node, whose index is smaller. A plane lies strictly within its node's cell. A cell is closed: it contains its
// faces.
//
// Triangles are padded when they are sorted into leaves, and `bounds` is padded likewise: padding.h says by how much, and why
// no traverser needs an epsilon. So a hit with t <= t_max of a leaf is the nearest, and no cell is flat.
#pragma once

#include <bit>
#include <cstdint>
#include <type_traits>

#include "libaccel/core/aabb.h"
#include "libaccel/core/result.h"
#include "libaccel/structure/arrays.h"
#include "libaccel/structure/reference_leaf.h"

namespace accel {

inline constexpr std::uint32_t kKdLeaf = 3;  // in place of an axis

// An inner node: the plane, and the axis and the index of its lower child. A leaf: the name of its references
// (reference_leaf.h), and its number among the leaves.
struct alignas(8) KdNode {
  std::uint32_t payload;
  std::uint32_t link;

  static KdNode inner(int axis, float plane, std::uint32_t lower_child) {
    return {std::bit_cast<std::uint32_t>(plane), lower_child << 2 | static_cast<std::uint32_t>(axis)};
  }
  static KdNode leaf(std::uint32_t first_reference, std::uint32_t ordinal) { return {first_reference, ordinal << 2 | kKdLeaf}; }

  ACCEL_HD bool is_leaf() const { return (link & 3) == kKdLeaf; }
  ACCEL_HD int axis() const { return static_cast<int>(link & 3); }
  ACCEL_HD float plane() const { return std::bit_cast<float>(payload); }
  ACCEL_HD std::uint32_t lower_child() const { return link >> 2; }  // the upper child is the next node
  ACCEL_HD std::uint32_t first_reference() const { return payload; }
  ACCEL_HD std::uint32_t ordinal() const { return link >> 2; }
};
static_assert(sizeof(KdNode) == 8 && std::is_trivially_copyable_v<KdNode>);

inline constexpr std::uint32_t kMaxKdNodes = 1u << 30;
inline constexpr std::uint32_t kKdRoot = 0;
ACCEL_HD std::uint32_t pair_of(std::uint32_t node) { return node >> 1; }
ACCEL_HD std::uint32_t sibling_of(std::uint32_t node) { return node ^ 1u; }

// The neighbours of a leaf (Popov et al. 2007): for each face the smallest subtree that holds all leaves behind it, or kNoRope
// at the border of the tree.
inline constexpr std::uint32_t kNoRope = 0xffffffffu;
struct LeafRopes {
  Aabb cell;
  std::uint32_t rope[6];  // nodes behind the lower faces, x, y, z, and behind the upper ones
};
static_assert(sizeof(LeafRopes) == 48 && std::is_trivially_copyable_v<LeafRopes>);

// Arrays beyond nodes and leaves; a traverser names those that it reads as `static constexpr KdExtras kNeeds`.
enum class KdExtras : std::uint8_t { parents_and_boxes, ropes };

// What a traverser needs, passed to kernels by value.
struct KdTreeView {
  const KdNode* nodes = nullptr;  // null: an empty scene
  ReferenceLeavesView leaves;
  Aabb bounds;                             // the root's cell
  const std::uint32_t* parents = nullptr;  // by pair: the inner node that it belongs to; pair 0 is the root's, unused
  const Aabb* cells = nullptr;             // by pair: the cell of that inner node
  const LeafRopes* ropes = nullptr;        // by ordinal
};

// The most inner nodes on a path that traversers with a stack accept.
inline constexpr int kKdStackSize = 64;

// What of a KdTree is no array.
struct KdTreeWords {
  Aabb bounds;
  std::uint32_t depth = 0;       // inner nodes on the longest path from the root
  std::uint32_t leaf_count = 0;  // empty ones too
};
static_assert(sizeof(KdTreeWords) == 32 && std::is_trivially_copyable_v<KdTreeWords>);

// The owning structure.
struct KdTree : KdTreeWords {
  static constexpr const char* kName = "kdtree";
  using View = KdTreeView;
  using Words = KdTreeWords;

  Buffer<KdNode> nodes;
  ReferenceLeaves leaves;
  Buffer<std::uint32_t> parents;  // empty, or as in the view
  Buffer<Aabb> cells;
  Buffer<LeafRopes> ropes;

  // What may be annotated: see registry/annotate.h.
  static constexpr KdExtras kExtras[] = {KdExtras::parents_and_boxes, KdExtras::ropes};
  static constexpr const char* extras_name(KdExtras extras) {
    return extras == KdExtras::ropes ? "ropes" : "parents and boxes";
  }
  bool has(KdExtras extras) const { return nodes.empty() || (extras == KdExtras::ropes ? !ropes.empty() : !parents.empty()); }
  template <class Self, class Visit>
  static void for_each_array(Self& self, Visit&& visit) {
    visit("nodes", self.nodes);
    ReferenceLeaves::for_each_array(self.leaves, visit);
    visit("parents", self.parents);
    visit("cells", self.cells);
    visit("ropes", self.ropes);
  }
  std::size_t size_bytes() const { return bytes_of_arrays(*this); }
  KdTreeView view() const { return {nodes.data(), leaves.view(), bounds, parents.data(), cells.data(), ropes.data()}; }
};

// Proves every invariant that traversal relies on, whatever the bytes are: pairs owned by one node each, before them; planes
// strictly within finite cells; leaves named by whole runs of references, each run by one leaf, and numbered without gaps;
// slots and prim_ids in range; depth as stated; parents, cells and ropes, where there are any, those of this tree. That a
// triangle is in every leaf it should be in, which a traversal needs to find its hits but not to be safe, is left to builders.
Status validate(const KdTree& tree, std::uint64_t triangle_count);

}  // namespace accel
