// Two levels of eight-wide BVHs: a tree over instances, whose leaves lead into the trees over their meshes.
//
// As structure/two_level.h, which says what the levels are, in a form that rays change between at little cost: all trees share
// one array of nodes and one of blocks, and references count from the beginning of those. So a ray that enters an instance
// takes along where it goes on, and the state of the ray itself.
//
// A leaf of the tree over instances is a run of instances (nearly always one) in the order of the array; the last of a run says
// so. A reference to the first of them has the bits of a leaf with more blocks than any has, by which is_instance() knows it.
//
// Invariants, proved by validate() for files: tree 0 is the one over instances; the nodes and blocks of each tree follow those
// of the tree before it, without gaps, and are a valid Bvh8; every run of instances is the leaf of one node; instances begin at
// the root of a mesh's tree, have prim_ids of the scene, and their inverse maps are finite. Which map and which prim_ids belong
// to which instance, and that boxes contain what they should, is the builder's word.
#pragma once

#include <cstdint>
#include <type_traits>
#include <vector>

#include "libaccel/core/affine.h"
#include "libaccel/structure/bvh8.h"

namespace accel {

// The last two references with these bits are no instances: one that is left to traversal, and kNoNode.
inline constexpr NodeRef kInstanceBits = kLeafBit | (kMostCounted + 1) << kBlockBits;
inline constexpr std::uint32_t kMostInstances = kMaxBlocks - 2;
ACCEL_HD NodeRef instance_ref(std::uint32_t instance) { return kInstanceBits | instance; }
ACCEL_HD bool is_instance(NodeRef ref) { return ref >= kInstanceBits && ref < instance_ref(kMostInstances); }
ACCEL_HD std::uint32_t instance_number(NodeRef ref) { return ref & ~kInstanceBits; }

// A tree, as a range of the arrays. The root counts from their beginning, as all references do.
struct Bvh8Tree : Bvh8Words {
  std::uint64_t first_node = 0, nodes = 0;
  std::uint64_t first_block = 0, blocks = 0;
  std::uint64_t triangles = 0;  // of the mesh; of tree 0: instances
};
static_assert(std::is_trivially_copyable_v<Bvh8Tree>);

// An instance, as a traverser needs it: one line of a CPU's cache.
struct alignas(64) Bvh8Instance {
  AffineInverse to_object;
  NodeRef root;  // of its mesh's tree
  std::uint32_t tree;
  std::uint32_t first_prim;  // prim_ids in the scene are this plus those in the tree
  std::uint32_t ends_leaf;   // 1 for the last of a run, else 0
};
static_assert(sizeof(Bvh8Instance) == 64 && std::is_trivially_copyable_v<Bvh8Instance>);

// That of the tree over instances. The depth is that of the deepest tree.
struct TwoLevelBvh8View : Bvh8View {
  using Tree = Bvh8View;

  const Bvh8Instance* instances = nullptr;

  ACCEL_HD Bvh8View top() const { return *this; }
  ACCEL_HD Bvh8View tree_of(const Bvh8Instance& instance) const {
    Bvh8View view = *this;
    view.root = instance.root;
    return view;
  }
};

struct TwoLevelBvh8Words {
  NodeRef root = kNoNode;   // of tree 0
  std::uint32_t depth = 0;  // of the deepest tree: a traversal holds one path in each of two
};

struct TwoLevelBvh8 : TwoLevelBvh8Words {
  static constexpr const char* kName = "bvh8-levels";
  using View = TwoLevelBvh8View;
  using Words = TwoLevelBvh8Words;

  Buffer<Bvh8Node> nodes;
  Buffer<TriangleBlock> blocks;
  Buffer<Bvh8Tree> trees;
  Buffer<Bvh8Instance> instances;  // those that rays can hit

  template <class Self, class Visit>
  static void for_each_array(Self& self, Visit&& visit) {
    visit("nodes", self.nodes);
    visit("blocks", self.blocks);
    visit("trees", self.trees);
    visit("instances", self.instances);
  }
  std::size_t size_bytes() const { return bytes_of_arrays(*this); }
  TwoLevelBvh8View view() const { return {{nodes.data(), blocks.data(), root, depth}, instances.data()}; }

  // Tree i as a structure of its own, which shares the blocks and has its own nodes. The tree's ranges lie in the arrays;
  // references that do not lie in the ranges name a node that there is not. The tree over instances gets blocks, in which each
  // instance has a triangle whose prim_id is its number, and whose coordinates are zero. O(n).
  Bvh8 tree(std::size_t i) const;

  // Puts trees one behind the other, that over instances first, whose leaves name the numbers of instances in place of
  // prim_ids: the only ones that get a place. triangles[i] is Bvh8Tree's; of the instances only roots and ends are filled in.
  // Fails when nodes, blocks or instances outgrow the bits of a reference.
  static Result<TwoLevelBvh8> join(const std::vector<Bvh8>& trees, const std::vector<std::uint64_t>& triangles,
                                   const Buffer<Bvh8Instance>& instances);

  // The same trees over meshes below another tree over other instances, as join() takes them, each of one of these meshes;
  // blocks are shared. O(nodes).
  Result<TwoLevelBvh8> with_top(const Bvh8& top, const Buffer<Bvh8Instance>& instances) const;

 private:
  // Fills in tree 0 and the instances, where all else is there.
  void place_top(const Bvh8& top, const Buffer<Bvh8Instance>& with);
};

// As validate(const Bvh8&, ...); `triangle_count` is the number of prim_ids of the whole scene.
Status validate(const TwoLevelBvh8& bvh, std::uint64_t triangle_count);

}  // namespace accel
