#include "libaccel/structure/two_level.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace accel {
namespace {

// Whether [first, first + count) begins at `expected` and ends within `size`.
bool follows(std::uint64_t first, std::uint64_t count, std::uint64_t expected, std::uint64_t size) {
  return first == expected && count <= size - expected;
}

Status validate_trees(const TwoLevelBvh& bvh) {
  std::uint64_t nodes = 0, quads = 0;
  std::uint32_t depth = 0;
  for (std::size_t i = 0; i < bvh.trees.size(); ++i) {
    const TwoLevelTree& t = bvh.trees[i];
    const std::string name = "tree " + std::to_string(i);
    if (!follows(t.first_node, t.nodes, nodes, bvh.nodes.size()) || !follows(t.first_quad, t.quads, quads, bvh.leaves.size()))
      return Error{name + " is not the part of the arrays that comes after the tree before it"};
    if (const Status valid = validate(bvh.tree(i), t.triangles); !valid) return Error{name + ": " + valid.message()};
    nodes += t.nodes, quads += t.quads, depth = std::max(depth, t.depth);
  }
  if (nodes != bvh.nodes.size() || quads != bvh.leaves.size()) return Error{"there are nodes or leaves that belong to no tree"};
  if (depth != bvh.depth || bvh.trees[0].depth != bvh.instance_depth)
    return Error{"the depths of the trees are not what the structure says"};
  return Done{};
}

bool is_finite(const AffineInverse& map) {
  const auto finite = [](float x) { return std::isfinite(x); };
  return std::all_of(&map.linear[0][0], &map.linear[0][0] + 9, finite) && finite(map.origin.x) && finite(map.origin.y) &&
         finite(map.origin.z);
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
  return bvh;
}

Status validate(const TwoLevelBvh& bvh, std::uint64_t triangle_count) {
  if (bvh.trees.empty()) {
    if (bvh.nodes.empty() && bvh.leaves.empty() && bvh.instances.empty() && triangle_count == 0) return Done{};
    return Error{"there is no tree, but there are nodes, leaves, instances or triangles"};
  }
  if (bvh.trees[0].triangles != bvh.instances.size())
    return Error{"the tree over instances is one over " + std::to_string(bvh.trees[0].triangles) + ", but there are " +
                 std::to_string(bvh.instances.size())};
  if (const Status good = validate_trees(bvh); !good) return good;
  return validate_instances(bvh, triangle_count);
}

}  // namespace accel
