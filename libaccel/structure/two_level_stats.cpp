#include "libaccel/structure/two_level_stats.h"

#include <algorithm>
#include <vector>

namespace accel {
namespace {

void add(const std::vector<std::uint64_t>& from, std::vector<std::uint64_t>& to) {
  to.resize(std::max(to.size(), from.size()));
  for (std::size_t i = 0; i < from.size(); ++i) to[i] += from[i];
}

// Moves a mean towards another by a share of the way.
void move(double share, double other, double& mean) { mean += share * (other - mean); }

// Means that only one of the two kinds has.
void move_means(double share, const Bvh2Stats& from, Bvh2Stats& to) {
  move(share, from.mean_leaf_depth, to.mean_leaf_depth);
  to.node_bytes += from.node_bytes, to.leaf_bytes += from.leaf_bytes;
}
void move_means(double, const Bvh8Stats& from, Bvh8Stats& to) {
  const auto blocks = [](const Bvh8Stats& s) {
    return s.references > 0 ? static_cast<double>(s.references) / s.mean_block_size : 0;
  };
  const double nodes = static_cast<double>(from.inner_nodes + to.inner_nodes);
  if (nodes > 0) move(static_cast<double>(from.inner_nodes) / nodes, from.mean_children, to.mean_children);
  const double all_blocks = blocks(from) + blocks(to);
  if (all_blocks > 0) move(blocks(from) / all_blocks, from.mean_block_size, to.mean_block_size);
}

// Means of both together; they weigh as many leaves as they are of.
template <class Stats>
void add(const Stats& from, Stats& to) {
  if (from.leaves > 0) {
    const double share = static_cast<double>(from.leaves) / static_cast<double>(from.leaves + to.leaves);
    const double apart = from.mean_leaf_size - to.mean_leaf_size;
    to.leaf_size_variance += share * (from.leaf_size_variance - to.leaf_size_variance) + share * (1 - share) * apart * apart;
    to.mean_leaf_size += share * apart;
    move_means(share, from, to);
  }
  to.inner_nodes += from.inner_nodes, to.leaves += from.leaves;
  to.triangles += from.triangles, to.references += from.references;
  to.depth = std::max(to.depth, from.depth);
  add(from.leaves_by_depth, to.leaves_by_depth), add(from.leaves_by_size, to.leaves_by_size);
}

// The tree over instances: its root, the references and boxes of its children, and what a leaf costs where a tree costs
// cost_of_tree[i].
class TopOf2 {
 public:
  TopOf2(const TwoLevelBvh& bvh, const std::vector<double>& cost_of_tree)
      : bvh_(bvh), cost_of_tree_(cost_of_tree), top_(bvh.tree(0)) {}

  NodeRef root() const { return top_.root; }
  double root_area() const { return half_area_in_double(top_.bounds); }
  template <class Visit>
  void for_each_child(const Visit& visit) const {
    for (const Bvh2Node& node : top_.nodes)
      for (int c = 0; c < 2; ++c) visit(node.child[c], node.bounds(c));
  }
  double leaf_cost(NodeRef leaf) const {
    double cost = 0;
    for (std::uint32_t quad = leaf_quad(leaf); !is_end_of_leaf(top_.leaves.data(), quad); quad += kQuadsPerTriangle)
      cost += cost_of_tree_[bvh_.instances[top_.leaves[quad].word].tree];
    return cost;
  }

 private:
  const TwoLevelBvh& bvh_;
  const std::vector<double>& cost_of_tree_;
  Bvh2 top_;
};

class TopOf8 {
 public:
  TopOf8(const TwoLevelBvh8& bvh, const std::vector<double>& cost_of_tree) : bvh_(bvh), cost_of_tree_(cost_of_tree) {}

  NodeRef root() const { return bvh_.root; }
  double root_area() const { return half_area_in_double(bvh_.trees[0].bounds); }
  template <class Visit>
  void for_each_child(const Visit& visit) const {
    for (std::uint64_t n = 0; n < bvh_.trees[0].nodes; ++n)
      for (std::uint32_t c = 0; c < kBvh8Arity && bvh_.nodes[n].child[c] != kNoNode; ++c)
        visit(bvh_.nodes[n].child[c], bvh_.nodes[n].bounds(c));
  }
  double leaf_cost(NodeRef leaf) const {
    double cost = 0;
    std::uint32_t i = instance_number(leaf);
    do cost += cost_of_tree_[bvh_.instances[i].tree];
    while (bvh_.instances[i++].ends_leaf == 0);
    return cost;
  }

 private:
  const TwoLevelBvh8& bvh_;
  const std::vector<double>& cost_of_tree_;
};

template <class Top>
double cost_of_scene(const Top& top, float traversal_cost) {
  if (top.root() == kNoNode) return 0;
  if (is_leaf(top.root())) return top.leaf_cost(top.root());
  if (!(top.root_area() > 0)) return 0;
  double cost = traversal_cost * top.root_area();
  top.for_each_child([&](NodeRef child, const Aabb& box) {
    cost += half_area_in_double(box) * (is_leaf(child) ? top.leaf_cost(child) : traversal_cost);
  });
  return cost / top.root_area();
}

template <class Top, class Structure, class StatsOf>
auto stats_of_levels(const Structure& bvh, float traversal_cost, const StatsOf& stats_of) {
  TwoLevelStats<std::invoke_result_t<StatsOf, std::size_t>> stats;
  if (bvh.trees.empty()) return stats;
  stats.instances = stats_of(0);
  std::vector<double> cost_of_tree(bvh.trees.size());
  for (std::size_t i = 1; i < bvh.trees.size(); ++i) {
    const auto tree = stats_of(i);
    cost_of_tree[i] = tree.sah_cost;
    add(tree, stats.meshes);
  }
  stats.sah_cost = cost_of_scene(Top(bvh, cost_of_tree), traversal_cost);
  return stats;
}

}  // namespace

TwoLevelStats<Bvh2Stats> two_level_stats(const TwoLevelBvh& bvh, float traversal_cost, float intersection_cost) {
  return stats_of_levels<TopOf2>(bvh, traversal_cost,
                                 [&](std::size_t i) { return bvh2_stats(bvh.tree(i), traversal_cost, intersection_cost); });
}
TwoLevelStats<Bvh8Stats> two_level_stats(const TwoLevelBvh8& bvh, float traversal_cost, float intersection_cost) {
  return stats_of_levels<TopOf8>(bvh, traversal_cost,
                                 [&](std::size_t i) { return bvh8_stats(bvh.tree(i), traversal_cost, intersection_cost); });
}

}  // namespace accel
