#include "libaccel/structure/bvh2_stats.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <numeric>

#include "libaccel/geometry/clip_triangle.h"
#include "libaccel/structure/histogram.h"

namespace accel {
namespace {

std::uint32_t leaf_size(const Bvh2& bvh, NodeRef leaf) {
  std::uint32_t size = 0;
  for (std::uint32_t quad = leaf_quad(leaf); !is_end_of_leaf(bvh.leaves.data(), quad); quad += kQuadsPerTriangle) ++size;
  return size;
}

// One reference of a leaf: which triangle, where it is stored, and the leaf's rank in depth-first order.
struct RankedReference {
  std::uint32_t prim_id, quad, rank;
};

// Depth-first order of a tree: leaves under each inner node, and all references by triangle.
struct DepthFirstOrder {
  std::vector<std::uint32_t> leaves_under;  // by node
  std::vector<RankedReference> references;  // sorted by prim_id
  std::vector<std::size_t> first;           // of each triangle in `references`, and the end

  explicit DepthFirstOrder(const Bvh2& bvh) : leaves_under(bvh.nodes.size()) {
    references.reserve(bvh.references);
    rank_leaves(bvh);
    std::sort(references.begin(), references.end(), [](const RankedReference& a, const RankedReference& b) {
      return a.prim_id < b.prim_id || (a.prim_id == b.prim_id && a.rank < b.rank);
    });
    for (std::size_t i = 0; i < references.size(); ++i)
      if (i == 0 || references[i].prim_id != references[i - 1].prim_id) first.push_back(i);
    first.push_back(references.size());
  }

  std::uint32_t leaves_below(NodeRef ref) const { return is_leaf(ref) ? 1 : leaves_under[ref]; }

 private:
  void rank_leaves(const Bvh2& bvh) {
    std::vector<NodeRef> pending{bvh.root}, order;
    std::uint32_t rank = 0;
    while (!pending.empty()) {
      const NodeRef ref = pending.back();
      pending.pop_back();
      if (is_leaf(ref)) {
        for (std::uint32_t quad = leaf_quad(ref); !is_end_of_leaf(bvh.leaves.data(), quad); quad += kQuadsPerTriangle)
          references.push_back({bvh.leaves[quad].word, quad, rank});
        ++rank;
      } else {
        order.push_back(ref);
        pending.push_back(bvh.nodes[ref].child[1]), pending.push_back(bvh.nodes[ref].child[0]);
      }
    }
    for (std::size_t i = order.size(); i-- > 0;) {
      const Bvh2Node& node = bvh.nodes[order[i]];
      leaves_under[order[i]] = leaves_below(node.child[0]) + leaves_below(node.child[1]);
    }
  }
};

// The area of one triangle in nodes that it does not belong to, weighted by the nodes' costs.
class TriangleOverlap {
 public:
  TriangleOverlap(const Bvh2& bvh, const DepthFirstOrder& order, float traversal_cost, float intersection_cost)
      : bvh_(bvh), order_(order), traversal_cost_(traversal_cost), intersection_cost_(intersection_cost) {}

  // Of the triangle number `index` in the order of prim_ids.
  double measure(std::size_t index, const ClippedPolygon& polygon) {
    begin_ = order_.references.data() + order_.first[index], end_ = order_.references.data() + order_.first[index + 1];
    double sum = 0;
    pending_.assign(1, {bvh_.root, 0, polygon});
    while (!pending_.empty()) {
      const Visit visit = pending_.back();
      pending_.pop_back();
      if (!is_leaf(visit.ref)) sum += visit_children(visit);
    }
    return sum;
  }

 private:
  struct Visit {
    NodeRef ref;
    std::uint32_t first_rank;  // of the leaves below
    ClippedPolygon polygon;    // the triangle's part in the node's box
  };

  double visit_children(const Visit& visit) {
    const Bvh2Node& node = bvh_.nodes[visit.ref];
    double sum = 0;
    std::uint32_t rank = visit.first_rank;
    for (int c = 0; c < 2; ++c) {
      Visit child{node.child[c], rank, visit.polygon};
      const std::uint32_t leaves = order_.leaves_below(child.ref);
      rank += leaves;
      if (!child.polygon.is_inside(node.bounds(c))) child.polygon.clip(node.bounds(c));
      const double area = child.polygon.area();
      if (!(area > 0)) continue;
      if (!belongs_to(child.first_rank, child.first_rank + leaves)) sum += area * cost(child.ref);
      pending_.push_back(child);
    }
    return sum;
  }

  bool belongs_to(std::uint32_t first_rank, std::uint32_t end_rank) const {
    const auto at =
        std::lower_bound(begin_, end_, first_rank, [](const RankedReference& r, std::uint32_t rank) { return r.rank < rank; });
    return at != end_ && at->rank < end_rank;
  }

  double cost(NodeRef ref) const {
    return is_leaf(ref) ? static_cast<double>(intersection_cost_) * leaf_size(bvh_, ref) : traversal_cost_;
  }

  const Bvh2& bvh_;
  const DepthFirstOrder& order_;
  const float traversal_cost_, intersection_cost_;
  const RankedReference *begin_ = nullptr, *end_ = nullptr;
  std::vector<Visit> pending_;
};

// Collects the sums of bvh2_stats(), leaf by leaf.
struct LeafSums {
  double size = 0, squared_size = 0, depth = 0;
};

void count_leaf(const Bvh2& bvh, NodeRef leaf, std::uint32_t depth, Bvh2Stats& stats, LeafSums& sums) {
  const std::uint32_t size = leaf_size(bvh, leaf);
  ++stats.leaves, stats.references += size;
  stats.depth = std::max(stats.depth, depth);
  count_in(stats.leaves_by_depth, depth);
  count_in(stats.leaves_by_size, std::min<std::size_t>(size, kLargestCountedLeaf));
  sums.size += size, sums.squared_size += static_cast<double>(size) * size, sums.depth += depth;
}

std::uint64_t count_distinct_triangles(const Bvh2& bvh) {
  std::vector<bool> seen;
  std::uint64_t count = 0;
  for (std::size_t quad = 0; quad < bvh.leaves.size();) {
    const std::uint32_t word = bvh.leaves[quad].word;
    quad += word == kEndOfLeaf ? 1 : kQuadsPerTriangle;
    count += word != kEndOfLeaf && is_first(seen, word) ? 1 : 0;
  }
  return count;
}

}  // namespace

Bvh2Stats bvh2_stats(const Bvh2& bvh, float traversal_cost, float intersection_cost) {
  Bvh2Stats stats;
  stats.inner_nodes = bvh.nodes.size();
  stats.node_bytes = bvh.nodes.size_bytes(), stats.leaf_bytes = bvh.leaves.size_bytes();
  if (bvh.root == kNoNode) return stats;

  struct Visit {
    NodeRef ref;
    std::uint32_t depth;
    double area;
  };
  LeafSums sums;
  double cost = 0;
  const double root_area = half_area_in_double(bvh.bounds);
  std::vector<Visit> pending{{bvh.root, 0, root_area}};
  while (!pending.empty()) {
    const Visit visit = pending.back();
    pending.pop_back();
    if (is_leaf(visit.ref)) {
      const std::uint64_t before = stats.references;
      count_leaf(bvh, visit.ref, visit.depth, stats, sums);
      cost += visit.area * intersection_cost * static_cast<double>(stats.references - before);
      continue;
    }
    cost += visit.area * traversal_cost;
    const Bvh2Node& node = bvh.nodes[visit.ref];
    for (int c = 0; c < 2; ++c) pending.push_back({node.child[c], visit.depth + 1, half_area_in_double(node.bounds(c))});
  }
  const auto leaves = static_cast<double>(stats.leaves);
  stats.sah_cost = root_area > 0 ? cost / root_area : 0.0;
  stats.mean_leaf_depth = sums.depth / leaves, stats.mean_leaf_size = sums.size / leaves;
  stats.leaf_size_variance = std::max(0.0, sums.squared_size / leaves - stats.mean_leaf_size * stats.mean_leaf_size);
  stats.triangles = count_distinct_triangles(bvh);
  return stats;
}

double end_point_overlap(const Bvh2& bvh, float traversal_cost, float intersection_cost, std::uint32_t stride) {
  if (bvh.root == kNoNode) return 0.0;
  constexpr std::size_t kTrianglesPerTask = 256;
  const DepthFirstOrder order(bvh);
  const std::size_t step = std::max(stride, 1u);
  const std::size_t measured = (order.first.size() - 1 + step - 1) / step;
  const std::size_t tasks = (measured + kTrianglesPerTask - 1) / kTrianglesPerTask;
  std::vector<double> overlap(tasks), surface(tasks);
  tbb::parallel_for(std::size_t{0}, tasks, [&](std::size_t task) {
    TriangleOverlap triangle_overlap(bvh, order, traversal_cost, intersection_cost);
    const std::size_t end = std::min((task + 1) * kTrianglesPerTask, measured);
    for (std::size_t i = task * kTrianglesPerTask; i < end; ++i) {
      const PackedTriangle& t = packed_triangle(bvh.leaves.data(), order.references[order.first[i * step]].quad);
      const ClippedPolygon polygon({t.vertex(0), t.vertex(1), t.vertex(2)});
      surface[task] += polygon.area();
      overlap[task] += triangle_overlap.measure(i * step, polygon);
    }
  });
  const double total = std::accumulate(surface.begin(), surface.end(), 0.0);
  return total > 0 ? std::accumulate(overlap.begin(), overlap.end(), 0.0) / total : 0.0;
}

}  // namespace accel
