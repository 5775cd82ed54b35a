#include "libaccel/structure/kdtree_stats.h"

#include <algorithm>

#include "libaccel/structure/histogram.h"

namespace accel {
namespace {

std::uint32_t leaf_size(const KdTree& tree, const KdNode& leaf) {
  if (leaf.first_reference() == kEmptyLeaf) return 0;
  std::uint32_t end = leaf.first_reference();
  while (!is_last(tree.leaves.references[end])) ++end;
  return end + 1 - leaf.first_reference();
}

struct Visit {
  std::uint32_t index, depth;
  Aabb cell;
};

// Adds up the statistics; sums of squares and of depths are kept aside.
class Counting {
 public:
  explicit Counting(const KdTree& tree) : tree_(tree), root_area_(half_area_in_double(tree.bounds)) {}

  KdTreeStats run() {
    std::vector<Visit> pending{{kKdRoot, 0, tree_.bounds}};
    while (!pending.empty()) {
      const Visit visit = pending.back();
      pending.pop_back();
      const KdNode node = tree_.nodes[visit.index];
      if (node.is_leaf()) {
        count_leaf(visit, leaf_size(tree_, node));
        continue;
      }
      ++stats_.inner_nodes, stats_.expected_steps += half_area_in_double(visit.cell) / root_area_;
      Visit children[2] = {{node.lower_child(), visit.depth + 1, visit.cell},
                           {node.lower_child() + 1, visit.depth + 1, visit.cell}};
      children[0].cell.hi[node.axis()] = children[1].cell.lo[node.axis()] = node.plane();
      pending.push_back(children[1]), pending.push_back(children[0]);
    }
    finish();
    return stats_;
  }

 private:
  void count_leaf(const Visit& leaf, std::uint32_t size) {
    const double share = half_area_in_double(leaf.cell) / root_area_;
    ++stats_.leaves, stats_.empty_leaves += size == 0 ? 1 : 0, stats_.references += size;
    stats_.expected_leaves += share, stats_.expected_tests += share * size;
    stats_.depth = std::max(stats_.depth, leaf.depth);
    count_in(stats_.leaves_by_depth, leaf.depth);
    count_in(stats_.leaves_by_size, std::min<std::size_t>(size, kLargestCountedKdLeaf));
    squared_size_ += static_cast<double>(size) * size, depths_ += leaf.depth;
  }

  void finish() {
    const auto full = static_cast<double>(stats_.leaves - stats_.empty_leaves);
    stats_.mean_leaf_depth = depths_ / static_cast<double>(stats_.leaves);
    stats_.triangles = tree_.leaves.triangles.size();
    if (full == 0) return;
    stats_.mean_leaf_size = static_cast<double>(stats_.references) / full;
    stats_.leaf_size_variance = std::max(0.0, squared_size_ / full - stats_.mean_leaf_size * stats_.mean_leaf_size);
  }

  const KdTree& tree_;
  const double root_area_;
  KdTreeStats stats_;
  double squared_size_ = 0, depths_ = 0;
};

}  // namespace

KdTreeStats kdtree_stats(const KdTree& tree) { return tree.nodes.empty() ? KdTreeStats{} : Counting(tree).run(); }

}  // namespace accel
