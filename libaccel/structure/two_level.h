// Two levels of two-box BVHs: a tree over instances, whose leaves lead into the trees over their meshes.
//
// Each mesh has one tree in its own space, however often it is placed; a ray that reaches an instance goes on in that space
// (core/affine.h). The trees lie one behind the other in shared arrays, each with references that count from its own first node
// and quad, so that every one of them is a Bvh2 as it stands; links and hash tables are those of each tree by itself.
//
// The tree over instances. It is an ordinary Bvh2 over stand-ins: degenerate triangles from the lower to the upper corner of an
// instance's world box, with the number of the instance in place of a prim_id. So builders, statistics and annotations know
// nothing of instances. Its boxes contain the exact world points of the instance, and build/instances.h says by how much more.
//
// Invariants, proved by validate() for files: tree 0 is the one over instances, every tree is a valid Bvh2 in its range of the
// arrays, ranges follow each other without gaps, instances name trees of meshes, their prim_ids are consecutive (see
// geometry/instanced_meshes.h), and their inverse maps are finite. Which map belongs to which instance, and that boxes contain
// what they should, is the builder's word.
#pragma once

#include <bit>
#include <vector>

#include "libaccel/core/affine.h"
#include "libaccel/structure/bvh2.h"

namespace accel {

// A tree, as a range of the arrays.
struct TwoLevelTree : Bvh2Words {
  std::uint64_t first_node = 0, nodes = 0;
  std::uint64_t first_quad = 0, quads = 0;
  std::uint64_t first_displacement = 0, displacements = 0;
  std::uint64_t first_slot = 0, slots = 0;
  std::uint64_t hash_reciprocal = 0;  // NodeHashView::reciprocal: rays that enter an instance do not divide
  std::uint64_t triangles = 0;        // of the mesh; of tree 0: instances
};
static_assert(std::is_trivially_copyable_v<TwoLevelTree>);

// An instance, as a traverser needs it: one line of a CPU's cache.
struct alignas(64) TwoLevelInstance {
  AffineInverse to_object;
  std::uint32_t tree;
  std::uint32_t first_prim;  // prim_ids in the scene are this plus those in the tree
  std::uint32_t unused[2];   // zero
};
static_assert(sizeof(TwoLevelInstance) == 64 && std::is_trivially_copyable_v<TwoLevelInstance>);

struct TwoLevelView {
  using Tree = Bvh2View;

  const Bvh2Node* nodes = nullptr;
  const LeafQuad* leaves = nullptr;
  const TwoLevelTree* trees = nullptr;  // null: an empty scene
  const TwoLevelInstance* instances = nullptr;
  const std::uint32_t* displacements = nullptr;
  const NodeRef* slots = nullptr;
  std::uint32_t depth = 0;  // of the deepest tree

  ACCEL_HD Bvh2View tree(std::uint32_t i) const {
    const TwoLevelTree& t = trees[i];
    Bvh2View view{nodes + t.first_node, leaves + t.first_quad, t.root, t.depth};
    view.hash.displacements = displacements + t.first_displacement, view.hash.slots = slots + t.first_slot;
    view.hash.multiplier = t.hash_multiplier, view.hash.reciprocal = t.hash_reciprocal;
    view.hash.slot_count = static_cast<std::uint32_t>(t.slots);
    view.hash.log2_of_buckets = static_cast<std::uint32_t>(std::bit_width(t.displacements)) - 1;  // unused if there are none
    return view;
  }
  ACCEL_HD Bvh2View top() const { return trees != nullptr ? tree(0) : Bvh2View{}; }
  ACCEL_HD Bvh2View tree_of(const TwoLevelInstance& instance) const { return tree(instance.tree); }
};

struct TwoLevelWords {
  std::uint32_t depth = 0;           // of the deepest tree: a traversal holds one path in each of two
  std::uint32_t instance_depth = 0;  // of the tree over instances
};

struct TwoLevelBvh : TwoLevelWords {
  static constexpr const char* kName = "two-level";
  using View = TwoLevelView;
  using Words = TwoLevelWords;

  Buffer<Bvh2Node> nodes;
  Buffer<LeafQuad> leaves;
  Buffer<TwoLevelTree> trees;
  Buffer<TwoLevelInstance> instances;
  Buffer<std::uint32_t> displacements;
  Buffer<NodeRef> slots;

  static constexpr Bvh2Extras kExtras[] = {Bvh2Extras::parents, Bvh2Extras::uncles, Bvh2Extras::hash, Bvh2Extras::full_hash};
  static constexpr const char* extras_name(Bvh2Extras extras) { return Bvh2::extras_name(extras); }
  bool has(Bvh2Extras extras) const;  // in every tree
  template <class Self, class Visit>
  static void for_each_array(Self& self, Visit&& visit) {
    visit("nodes", self.nodes);
    visit("leaves", self.leaves);
    visit("trees", self.trees);
    visit("instances", self.instances);
    visit("displacements", self.displacements);
    visit("slots", self.slots);
  }
  std::size_t size_bytes() const { return bytes_of_arrays(*this); }
  TwoLevelView view() const {
    return {nodes.data(), leaves.data(), trees.data(), instances.data(), displacements.data(), slots.data(), depth};
  }

  // Tree i as a structure of its own that shares the arrays. The tree's ranges lie in them.
  Bvh2 tree(std::size_t i) const;

  // Puts trees one behind the other, that over instances first: all but the instances. triangles[i] is TwoLevelTree's.
  static TwoLevelBvh join(const std::vector<Bvh2>& trees, const std::vector<std::uint64_t>& triangles);
};

// As validate(const Bvh2&, ...); `triangle_count` is the number of prim_ids of the whole scene.
Status validate(const TwoLevelBvh& bvh, std::uint64_t triangle_count);

}  // namespace accel
