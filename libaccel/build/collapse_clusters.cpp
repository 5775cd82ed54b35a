#include "libaccel/build/collapse_clusters.h"

#include <limits>
#include <utility>
#include <vector>

#include "libaccel/build/parallel.h"
#include "libaccel/build/sah_bins.h"
#include "libaccel/build/wide_forests.h"
#include "libaccel/build/wide_node.h"

namespace accel {
namespace {

// The clusters that become the children of a node, in the order of the tree.
struct ClusterFamily {
  std::uint32_t child[kBvh8Arity];
  std::uint32_t count;
};

class Collapse {
 public:
  Collapse(const ClusterTree& tree, const BuildOptions& options)
      : clusters_(tree.clusters),
        leaves_(tree.leaves),
        rounds_(tree.rounds),
        options_(options),
        forests_(leaves_ - 1),
        parents_(leaves_ - 1),
        first_child_(leaves_ - 1),
        families_(leaves_ - 1) {}

  std::optional<WideNodes> run() {
    const auto root = static_cast<std::uint32_t>(2 * leaves_ - 2);
    if (is_leaf_cluster(root)) return WideNodes{{}, block_ref(0, 1), 0};
    choose(root);
    if (!list_levels(root)) return std::nullopt;
    WideNodes wide{Buffer<Bvh8Node>(count_), 0, depth_};
    for_chunks(0, count_, [&](std::size_t, std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) make_node(i, wide.nodes[i]);
    });
    return wide;
  }

 private:
  bool is_leaf_cluster(std::uint32_t cluster) const { return cluster < leaves_; }
  const WideForests& forests(std::uint32_t cluster) const { return forests_[cluster - leaves_]; }

  // Costs, from the leaves up: the nodes of a round know nothing of each other.
  void choose(std::uint32_t root) {
    scale_ = unit_scale(clusters_[root].box());
    for (std::size_t r = 0; r + 1 < rounds_.size(); ++r)
      for_chunks(rounds_[r], rounds_[r + 1], [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) choose_of(i);
      });
  }
  void choose_of(std::size_t i) {
    const Cluster& cluster = clusters_[i];
    const Box4 own = cluster.box(), first = clusters_[cluster.first].box(), second = clusters_[cluster.second].box();
    const Float4 lo[4] = {own.lo, first.lo, second.lo, own.lo}, hi[4] = {own.hi, first.hi, second.hi, own.hi};
    float area[4];
    half_areas(lo, hi, scale_, area);
    // Made for inner children too, and not used: whether a child is a leaf nobody can guess.
    const WideForests leaf[2] = {WideForests(area[1] * options_.intersection_cost),
                                 WideForests(area[2] * options_.intersection_cost)};
    forests_[i - leaves_].choose(*forests_of(cluster.first, leaf[0]), *forests_of(cluster.second, leaf[1]),
                                 area[0] * options_.traversal_cost, std::numeric_limits<float>::infinity());
  }
  const WideForests* forests_of(std::uint32_t cluster, const WideForests& leaf) const {
    return is_leaf_cluster(cluster) ? &leaf : &forests(cluster);
  }

  // Which clusters become nodes, level by level, and where the inner children of each begin. False if they are too deep.
  bool list_levels(std::uint32_t root) {
    parents_[0] = root, count_ = 1;
    for (std::size_t begin = 0; begin < count_; ++depth_) {
      if (depth_ == static_cast<std::uint32_t>(options_.max_depth)) return false;
      begin = list_level(begin, count_);
    }
    return true;
  }
  std::size_t list_level(std::size_t begin, std::size_t end) {
    std::vector<std::size_t> before(chunk_count(end - begin));
    for_chunks(begin, end, [&](std::size_t chunk, std::size_t first, std::size_t last) {
      std::size_t sum = 0;
      for (std::size_t i = first; i < last; ++i) {
        first_child_[i] = static_cast<std::uint32_t>(sum);
        const ClusterFamily& family = families_[i] = family_of(parents_[i]);
        for (std::uint32_t c = 0; c < family.count; ++c) sum += is_leaf_cluster(family.child[c]) ? 0 : 1;
      }
      before[chunk] = sum;
    });
    std::size_t next = end;
    for (std::size_t& n : before) next += std::exchange(n, next);
    count_ = next;
    for_chunks(begin, end, [&](std::size_t chunk, std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        std::size_t to = first_child_[i] += static_cast<std::uint32_t>(before[chunk]);
        const ClusterFamily& family = families_[i];
        for (std::uint32_t c = 0; c < family.count; ++c)
          if (!is_leaf_cluster(family.child[c])) parents_[to++] = family.child[c];
      }
    });
    return end;
  }

  ClusterFamily family_of(std::uint32_t parent) const {
    ClusterFamily family;
    family.count = 0;
    int roots = static_cast<int>(kBvh8Arity);
    const int left = forests(parent).left(roots);
    gather(clusters_[parent].first, left, family), gather(clusters_[parent].second, roots - left, family);
    return family;
  }
  // At most eight roots deep.
  void gather(std::uint32_t cluster, int roots, ClusterFamily& family) const {
    int left = 0;
    if (!is_leaf_cluster(cluster)) left = forests(cluster).left(roots);
    if (is_leaf_cluster(cluster) || roots == 1) {
      family.child[family.count++] = cluster;
      return;
    }
    gather(clusters_[cluster].first, left, family), gather(clusters_[cluster].second, roots - left, family);
  }

  void make_node(std::size_t i, Bvh8Node& node) const {
    const ClusterFamily& family = families_[i];
    NodeRef next = first_child_[i];
    WideChild children[kBvh8Arity];
    for (std::uint32_t c = 0; c < family.count; ++c) {
      const std::uint32_t cluster = family.child[c];
      children[c] = {is_leaf_cluster(cluster) ? block_ref(cluster, 1) : next++, clusters_[cluster].box()};
    }
    make_wide_node(children, family.count, node);
  }

  const Buffer<Cluster>& clusters_;
  const std::size_t leaves_;
  const std::vector<std::size_t>& rounds_;
  const BuildOptions& options_;
  Float4 scale_;
  Buffer<WideForests> forests_;                  // by inner cluster
  Buffer<std::uint32_t> parents_, first_child_;  // by wide node; there is room for as many as there are inner clusters
  Buffer<ClusterFamily> families_;               // likewise
  std::size_t count_ = 0;                        // of wide nodes
  std::uint32_t depth_ = 0;
};

}  // namespace

std::optional<WideNodes> collapse_clusters(const ClusterTree& tree, const BuildOptions& options) {
  return Collapse(tree, options).run();
}

std::uint64_t collapse_clusters_bytes(const ClusterTree& tree, const WideNodes& wide) {
  constexpr std::size_t kByCluster = sizeof(WideForests) + 2 * sizeof(std::uint32_t) + sizeof(ClusterFamily);
  return (tree.leaves - 1) * kByCluster + wide.nodes.size_bytes();
}

}  // namespace accel
