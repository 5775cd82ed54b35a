// The binary bounding-volume hierarchy in 64-byte nodes that hold the boxes of both children.
//
// Aila and Laine 2009, "Understanding the Efficiency of Ray Traversal on GPUs"; the padding and its uses are those of Binder
// and Keller 2016, "Efficient Stackless Hierarchy Traversal on GPUs with Backtracking in Constant Time", Fig. 4. Deviation: the
// planes of an axis are interleaved by child, so that one 8-byte load brings the near planes of both children.
//
// The padding of nodes has room for one kind of links: nothing, parent and sibling, or uncle and grand-uncle; the terminator of
// a leaf has three words of the same kind (Fig. 5), and the first triangle of a leaf two words that are otherwise zero. So a
// structure has links of one kind. Other annotations are arrays of their own.
//
// Invariants: every inner node but the root is the child of exactly one node; every leaf of the stream is referenced exactly
// once; depth is the largest number of inner nodes on a path; a child's box contains the parts of its triangles that the child
// stands for (a spatial split may give a triangle to several leaves). Builders keep them; validate() proves all but the last
// for files, which a traversal needs to find its hits but not to be safe.
#pragma once

#include <cstdint>

#include "libaccel/structure/arrays.h"
#include "libaccel/structure/node_hash.h"
#include "libaccel/structure/octo_node.h"
#include "libaccel/structure/triangle_leaf.h"

namespace accel {

struct alignas(64) Bvh2Node {
  float planes[3][4];  // per axis: lower planes of children 0 and 1, upper planes of children 0 and 1
  NodeRef child[2];
  NodeRef link[2];  // nothing (zero), parent and sibling, or uncle and grand-uncle; kNoNode where there is none

  void set_bounds(int c, const Aabb& box) {
    for (int a = 0; a < 3; ++a) planes[a][c] = box.lo[a], planes[a][2 + c] = box.hi[a];
  }
  Aabb bounds(int c) const {
    return {{planes[0][c], planes[1][c], planes[2][c]}, {planes[0][2 + c], planes[1][2 + c], planes[2][2 + c]}};
  }
};
static_assert(sizeof(Bvh2Node) == 64 && std::is_trivially_copyable_v<Bvh2Node>);

// What the padding holds. Links of a leaf are in its terminator: link[0] and link[1] as in a node, and with uncles the
// great-grand-uncle in link[2]. Uncle and grand-uncle of a leaf are in its first triangle's spare words too, so that whoever
// climbs over the leaf need not search for its end.
enum class Bvh2Links : std::uint32_t { none, parents, uncles };

// Which keys the hash tables hold: those that trace/bvh2_hash.h may look up, or those of all nodes but the root.
enum class HashedKeys : std::uint32_t { none, looked_up, all };

// Whether trace/bvh2_hash.h may look up the key of a node. It never does where the target is at hand. A target that was
// postponed in the last step down is in the register; nodes remember uncle and grand-uncle, leaves the great-grand-uncle too.
// So it looks up a node only from a nephew's grandchild (an inner node), or from a child of such (a leaf): from three levels
// below the sibling of the node, or four. A leaf four levels below has a parent three levels below, so one condition is left:
//
//   the key of a node can be looked up if and only if there is an inner node three levels below its sibling.
inline constexpr int kHashedDistance = 3;
inline bool has_inner_node_below(const Bvh2Node* nodes, NodeRef ref, int levels) {
  if (is_leaf(ref)) return false;
  const NodeRef* const child = nodes[ref].child;
  if (levels == 1) return !is_leaf(child[0]) || !is_leaf(child[1]);
  return has_inner_node_below(nodes, child[0], levels - 1) || has_inner_node_below(nodes, child[1], levels - 1);
}

// Skip pointers of one order of traversal (trace/bvh2_skip.h), one for each inner node: the ancestor whose second child comes
// after the node's subtree, or kNoSkip; and in the top bit, which of the node's own children is the first.
inline constexpr std::uint32_t kSkipOrderBit = 0x80000000u;
inline constexpr std::uint32_t kNoSkip = 0x7fffffffu;
ACCEL_HD std::uint32_t first_child(std::uint32_t skip) { return skip >> 31; }
ACCEL_HD std::uint32_t skip_target(std::uint32_t skip) { return skip & ~kSkipOrderBit; }
inline constexpr std::uint32_t kOctants = 8;

// What a traverser needs, passed to kernels by value.
struct Bvh2View {
  const Bvh2Node* nodes = nullptr;
  const LeafQuad* leaves = nullptr;
  NodeRef root = kNoNode;  // kNoNode: an empty scene
  std::uint32_t depth = 0;
  NodeHashView hash;
  const std::uint32_t* skips = nullptr;         // by node
  const std::uint32_t* octant_skips = nullptr;  // by octant of the ray's direction, then by node
  std::uint32_t node_count = 0;
  const OctoNode* octo = nullptr;
  std::uint32_t octo_count = 0;
  Aabb bounds;
};

// The most inner nodes on a path from the root that traversers with a stack accept: one postponed child per level. Builders
// keep to it by default.
inline constexpr int kBvh2StackSize = 128;

// What may be annotated: see registry/annotate.h.
enum class Bvh2Extras : std::uint8_t { parents, uncles, hash, full_hash, skips, octant_skips, octo };

// What of a Bvh2 is no array.
struct Bvh2Words {
  NodeRef root = kNoNode;
  std::uint32_t depth = 0;       // inner nodes on the longest path from the root
  std::uint64_t references = 0;  // triangles in the leaves, with repetitions
  Aabb bounds;                   // of the whole tree
  Bvh2Links links = Bvh2Links::none;
  HashedKeys hashed = HashedKeys::none;
  std::uint64_t hash_multiplier = 0;  // NodeHashView::multiplier
};
static_assert(sizeof(Bvh2Words) == 56 && std::is_trivially_copyable_v<Bvh2Words>);

// The owning structure.
struct Bvh2 : Bvh2Words {
  static constexpr const char* kName = "bvh2";
  using View = Bvh2View;
  using Words = Bvh2Words;

  Buffer<Bvh2Node> nodes;
  Buffer<LeafQuad> leaves;
  Buffer<std::uint32_t> displacements;  // the hash: both empty where no key is to be hashed
  Buffer<NodeRef> slots;
  Buffer<std::uint32_t> skips;  // empty, or as in the view
  Buffer<std::uint32_t> octant_skips;
  Buffer<OctoNode> octo;  // empty, or the tree with eight children a node

  static constexpr Bvh2Extras kExtras[] = {Bvh2Extras::parents,   Bvh2Extras::uncles, Bvh2Extras::hash,
                                           Bvh2Extras::full_hash, Bvh2Extras::skips,  Bvh2Extras::octant_skips,
                                           Bvh2Extras::octo};
  static constexpr const char* extras_name(Bvh2Extras extras) {
    constexpr const char* kNames[] = {
        "parents and siblings",     "uncles",    "hashed keys", "all keys hashed", "skip pointers",
        "skip pointers per octant", "octo nodes"};
    return kNames[static_cast<int>(extras)];
  }
  bool has(Bvh2Extras extras) const;
  template <class Self, class Visit>
  static void for_each_array(Self& self, Visit&& visit) {
    visit("nodes", self.nodes);
    visit("leaves", self.leaves);
    visit("hash.displacements", self.displacements);
    visit("hash.slots", self.slots);
    visit("skips", self.skips);
    visit("octant_skips", self.octant_skips);
    visit("octo", self.octo);
  }
  std::size_t size_bytes() const { return bytes_of_arrays(*this); }
  bool has_narrow_keys() const { return depth <= kMaxDepth32; }
  Bvh2View view() const;
};

// Proves every invariant that traversal relies on, whatever the bytes are: references in range, no node or leaf reached twice,
// none unreachable, every leaf terminated, ordered planes without NaN, prim_id < triangle_count, depth and counts as stated;
// links, hash tables and skip pointers, where there are any, those of this tree.
Status validate(const Bvh2& bvh, std::uint64_t triangle_count);

}  // namespace accel
