#include "libaccel/structure/two_level_stats.h"

#include <algorithm>
#include <vector>

namespace accel {
namespace {

void add(const std::vector<std::uint64_t>& from, std::vector<std::uint64_t>& to) {
  to.resize(std::max(to.size(), from.size()));
  for (std::size_t i = 0; i < from.size(); ++i) to[i] += from[i];
}

// Means of both together; they weigh as many leaves as they are of.
void add(const Bvh2Stats& from, Bvh2Stats& to) {
  if (from.leaves > 0) {
    const double share = static_cast<double>(from.leaves) / static_cast<double>(from.leaves + to.leaves);
    const double apart = from.mean_leaf_size - to.mean_leaf_size;
    to.leaf_size_variance += share * (from.leaf_size_variance - to.leaf_size_variance) + share * (1 - share) * apart * apart;
    to.mean_leaf_size += share * apart;
    to.mean_leaf_depth += share * (from.mean_leaf_depth - to.mean_leaf_depth);
  }
  to.inner_nodes += from.inner_nodes, to.leaves += from.leaves;
  to.triangles += from.triangles, to.references += from.references;
  to.node_bytes += from.node_bytes, to.leaf_bytes += from.leaf_bytes;
  to.depth = std::max(to.depth, from.depth);
  add(from.leaves_by_depth, to.leaves_by_depth), add(from.leaves_by_size, to.leaves_by_size);
}

// Of the tree over instances, where instance i costs cost_of_tree[its tree].
double cost_of_scene(const TwoLevelBvh& bvh, float traversal_cost, const std::vector<double>& cost_of_tree) {
  const Bvh2 top = bvh.tree(0);
  const auto leaf_cost = [&](NodeRef leaf) {
    double cost = 0;
    for (std::uint32_t quad = leaf_quad(leaf); !is_end_of_leaf(top.leaves.data(), quad); quad += kQuadsPerTriangle)
      cost += cost_of_tree[bvh.instances[top.leaves[quad].word].tree];
    return cost;
  };
  if (top.root == kNoNode) return 0;
  if (is_leaf(top.root)) return leaf_cost(top.root);
  const double root_area = half_area_in_double(top.bounds);
  if (!(root_area > 0)) return 0;
  double cost = traversal_cost * root_area;
  for (const Bvh2Node& node : top.nodes)
    for (int c = 0; c < 2; ++c)
      cost += half_area_in_double(node.bounds(c)) * (is_leaf(node.child[c]) ? leaf_cost(node.child[c]) : traversal_cost);
  return cost / root_area;
}

}  // namespace

TwoLevelStats two_level_stats(const TwoLevelBvh& bvh, float traversal_cost, float intersection_cost) {
  TwoLevelStats stats;
  if (bvh.trees.empty()) return stats;
  stats.instances = bvh2_stats(bvh.tree(0), traversal_cost, intersection_cost);
  std::vector<double> cost_of_tree(bvh.trees.size());
  for (std::size_t i = 1; i < bvh.trees.size(); ++i) {
    const Bvh2Stats tree = bvh2_stats(bvh.tree(i), traversal_cost, intersection_cost);
    cost_of_tree[i] = tree.sah_cost;
    add(tree, stats.meshes);
  }
  stats.sah_cost = cost_of_scene(bvh, traversal_cost, cost_of_tree);
  return stats;
}

}  // namespace accel
