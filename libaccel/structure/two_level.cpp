#include "libaccel/structure/two_level.h"

#include <algorithm>
#include <string>
#include <type_traits>

namespace accel {
namespace {

// The end of the ranges so far in one of the shared arrays.
struct Cursor {
  std::uint64_t size, end = 0;

  // Whether [first, first + count) comes next.
  bool take(std::uint64_t first, std::uint64_t count) {
    if (first != end || count > size - end) return false;
    end += count;
    return true;
  }
};

Status validate_trees(const TwoLevelBvh& bvh) {
  Cursor nodes{bvh.nodes.size()}, quads{bvh.leaves.size()}, displacements{bvh.displacements.size()}, slots{bvh.slots.size()};
  std::uint32_t depth = 0;
  for (std::size_t i = 0; i < bvh.trees.size(); ++i) {
    const TwoLevelTree& t = bvh.trees[i];
    const std::string name = "tree " + std::to_string(i);
    if (!nodes.take(t.first_node, t.nodes) || !quads.take(t.first_quad, t.quads) ||
        !displacements.take(t.first_displacement, t.displacements) || !slots.take(t.first_slot, t.slots))
      return Error{name + " is not the part of the arrays that comes after the tree before it"};
    const Bvh2 tree = bvh.tree(i);
    if (const Status valid = validate(tree, t.triangles); !valid) return Error{name + ": " + valid.message()};
    if (t.hash_reciprocal != tree.view().hash.reciprocal)
      return Error{name + " has a reciprocal that is not that of its slots"};
    depth = std::max(depth, t.depth);
  }
  for (const Cursor& array : {nodes, quads, displacements, slots})
    if (array.end != array.size) return Error{"there are nodes, leaves or hashed keys that belong to no tree"};
  if (depth != bvh.depth || bvh.trees[0].depth != bvh.instance_depth)
    return Error{"the depths of the trees are not what the structure says"};
  return Done{};
}

// One array of all trees.
template <class ArrayOf>
auto joined(const std::vector<Bvh2>& trees, std::uint64_t size, const ArrayOf& array_of) {
  using T = std::remove_cv_t<typename std::invoke_result_t<ArrayOf, const Bvh2&>::element_type>;
  Buffer<T> result(size);
  T* out = result.data();
  for (const Bvh2& tree : trees) {
    const auto part = array_of(tree);
    out = std::copy(part.begin(), part.end(), out);
  }
  return result;
}

Status validate_instances(const TwoLevelBvh& bvh, std::uint64_t triangle_count) {
  std::uint64_t prims = 0;
  for (std::size_t i = 0; i < bvh.instances.size(); ++i) {
    const TwoLevelInstance& instance = bvh.instances[i];
    const std::string name = "instance " + std::to_string(i);
    if (instance.tree == 0 || instance.tree >= bvh.trees.size())
      return Error{name + " names tree " + std::to_string(instance.tree) + ", which is none of a mesh"};
    if (!is_finite(instance.to_object)) return Error{name + " has a map that is not finite"};
    if (instance.first_prim != prims)
      return Error{name + " begins at prim_id " + std::to_string(instance.first_prim) + " instead of " + std::to_string(prims)};
    prims += bvh.trees[instance.tree].triangles;
    if (prims > triangle_count) return Error{name + " has triangles that the scene has not"};
  }
  if (prims != triangle_count)
    return Error{"the instances have " + std::to_string(prims) + " triangles instead of " + std::to_string(triangle_count)};
  return Done{};
}

}  // namespace

Bvh2 TwoLevelBvh::tree(std::size_t i) const {
  const TwoLevelTree& t = trees[i];
  Bvh2 bvh;
  static_cast<Bvh2Words&>(bvh) = t;
  bvh.nodes = nodes.part(t.first_node, t.nodes);
  bvh.leaves = leaves.part(t.first_quad, t.quads);
  bvh.displacements = displacements.part(t.first_displacement, t.displacements);
  bvh.slots = slots.part(t.first_slot, t.slots);
  return bvh;
}

bool TwoLevelBvh::has(Bvh2Extras extras) const {
  for (std::size_t i = 0; i < trees.size(); ++i)
    if (!tree(i).has(extras)) return false;
  return true;
}

TwoLevelBvh TwoLevelBvh::join(const std::vector<Bvh2>& trees, const std::vector<std::uint64_t>& triangles) {
  TwoLevelBvh result;
  result.trees = Buffer<TwoLevelTree>(trees.size());
  TwoLevelTree next{};
  for (std::size_t i = 0; i < trees.size(); ++i) {
    const Bvh2& tree = trees[i];
    static_cast<Bvh2Words&>(next) = tree;
    next.nodes = tree.nodes.size(), next.quads = tree.leaves.size();
    next.displacements = tree.displacements.size(), next.slots = tree.slots.size();
    next.hash_reciprocal = tree.view().hash.reciprocal;
    next.triangles = triangles[i];
    result.trees[i] = next;
    result.depth = std::max(result.depth, tree.depth);
    next.first_node += next.nodes, next.first_quad += next.quads;
    next.first_displacement += next.displacements, next.first_slot += next.slots;
  }
  result.instance_depth = trees.empty() ? 0 : trees[0].depth;
  result.nodes = joined(trees, next.first_node, [](const Bvh2& tree) { return tree.nodes.span(); });
  result.leaves = joined(trees, next.first_quad, [](const Bvh2& tree) { return tree.leaves.span(); });
  result.displacements = joined(trees, next.first_displacement, [](const Bvh2& tree) { return tree.displacements.span(); });
  result.slots = joined(trees, next.first_slot, [](const Bvh2& tree) { return tree.slots.span(); });
  return result;
}

Status validate(const TwoLevelBvh& bvh, std::uint64_t triangle_count) {
  if (bvh.trees.empty()) {
    if (bytes_of_arrays(bvh) == 0 && triangle_count == 0) return Done{};
    return Error{"there is no tree, but there are nodes, leaves, instances, hashed keys or triangles"};
  }
  if (bvh.trees[0].triangles != bvh.instances.size())
    return Error{"the tree over instances is one over " + std::to_string(bvh.trees[0].triangles) + ", but there are " +
                 std::to_string(bvh.instances.size())};
  if (const Status good = validate_trees(bvh); !good) return good;
  return validate_instances(bvh, triangle_count);
}

}  // namespace accel
