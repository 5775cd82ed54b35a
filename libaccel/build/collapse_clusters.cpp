#include "libaccel/build/collapse_clusters.h"

#include <algorithm>
#include <utility>

#include "libaccel/build/parallel.h"
#include "libaccel/build/wide_node.h"

namespace accel {
namespace {

// Nodes that one task makes at once.
constexpr std::size_t kNodesAtOnce = 512;

// The clusters that become the children of a node, in the order of the tree.
struct Family {
  std::uint32_t child[kBvh8Arity];
  double area[kBvh8Arity];
  std::uint32_t count = 0;
};

class Collapse {
 public:
  Collapse(const Buffer<Cluster>& clusters, std::size_t leaves) : clusters_(clusters), leaves_(leaves) {}

  std::optional<WideNodes> run(std::uint32_t max_depth) {
    const auto root = static_cast<std::uint32_t>(2 * leaves_ - 2);
    if (is_leaf_cluster(root)) return WideNodes{{}, block_ref(0, 1), 0};
    wide_.root = 0;
    for (std::vector<std::uint32_t> level{root}; !level.empty(); ++wide_.depth) {
      if (wide_.depth == max_depth) return std::nullopt;
      level = make_level(level);
    }
    return std::move(wide_);
  }

 private:
  bool is_leaf_cluster(std::uint32_t cluster) const { return cluster < leaves_; }

  // Makes the nodes of the clusters of a level. Returns the clusters of the next.
  std::vector<std::uint32_t> make_level(const std::vector<std::uint32_t>& level) {
    const std::size_t first = wide_.nodes.size(), tasks = (level.size() + kNodesAtOnce - 1) / kNodesAtOnce;
    wide_.nodes.resize(first + level.size());
    std::vector<Family> families(level.size());
    std::vector<std::size_t> inner(tasks);
    tbb::parallel_for(std::size_t{0}, tasks, [&](std::size_t task) {
      for (std::size_t i = task * kNodesAtOnce; i < std::min(level.size(), (task + 1) * kNodesAtOnce); ++i) {
        families[i] = family_of(level[i]);
        inner[task] += count_inner(families[i]);
      }
    });
    std::size_t sum = 0;
    for (std::size_t& n : inner) sum += std::exchange(n, sum);
    std::vector<std::uint32_t> next(sum);
    tbb::parallel_for(std::size_t{0}, tasks, [&](std::size_t task) {
      std::size_t to = inner[task];
      for (std::size_t i = task * kNodesAtOnce; i < std::min(level.size(), (task + 1) * kNodesAtOnce); ++i)
        wide_.nodes[first + i] = make_node(families[i], first + level.size(), next, to);
    });
    return next;
  }

  Family family_of(std::uint32_t parent) const {
    Family family;
    family.child[0] = parent, family.area[0] = 0, family.count = 1;
    for (std::uint32_t open = 0; open < kBvh8Arity;) {
      const Cluster& cluster = clusters_[family.child[open]];
      for (std::uint32_t c = family.count++; c > open + 1; --c)
        family.child[c] = family.child[c - 1], family.area[c] = family.area[c - 1];
      set(family, open, cluster.first), set(family, open + 1, cluster.second);
      open = family.count < kBvh8Arity ? largest_inner(family) : kBvh8Arity;
    }
    return family;
  }

  // Leaves have a negative area: they are never opened.
  void set(Family& family, std::uint32_t c, std::uint32_t cluster) const {
    family.child[c] = cluster;
    family.area[c] = is_leaf_cluster(cluster) ? -1.0 : half_area_in_double(clusters_[cluster].bounds());
  }
  static std::uint32_t largest_inner(const Family& family) {
    const auto largest = std::max_element(family.area, family.area + family.count);
    return *largest < 0 ? kBvh8Arity : static_cast<std::uint32_t>(largest - family.area);
  }
  static std::size_t count_inner(const Family& family) {
    return static_cast<std::size_t>(std::count_if(family.area, family.area + family.count, [](double a) { return a >= 0; }));
  }

  // Inner children become the nodes from `base` on, the first of them number `to` there.
  Bvh8Node make_node(const Family& family, std::size_t base, std::vector<std::uint32_t>& next, std::size_t& to) const {
    WideChild children[kBvh8Arity];
    for (std::uint32_t c = 0; c < family.count; ++c) {
      const std::uint32_t cluster = family.child[c];
      children[c].box = clusters_[cluster].bounds();
      if (is_leaf_cluster(cluster)) {
        children[c].ref = block_ref(cluster, 1);
      } else {
        children[c].ref = static_cast<NodeRef>(base + to);
        next[to++] = cluster;
      }
    }
    return make_wide_node(children, family.count);
  }

  const Buffer<Cluster>& clusters_;
  const std::size_t leaves_;
  WideNodes wide_;
};

}  // namespace

std::optional<WideNodes> collapse_clusters(const Buffer<Cluster>& clusters, std::size_t leaves, std::uint32_t max_depth) {
  return Collapse(clusters, leaves).run(max_depth);
}

}  // namespace accel
