#include "libaccel/structure/bvh8_stats.h"

#include <algorithm>

#include "libaccel/structure/bvh2_stats.h"
#include "libaccel/structure/bvh8_coded.h"
#include "libaccel/structure/histogram.h"

namespace accel {
namespace {

template <class Block>
std::uint32_t count_triangles(const Buffer<Block>& all, NodeRef leaf) {
  std::uint32_t size = 0;
  const std::uint32_t first = first_block(leaf), blocks = block_count(all, leaf);
  for (std::uint32_t b = first; b < first + blocks; ++b)
    for (std::uint32_t lane = 0; lane < kBlockLanes; ++lane) size += all[b].has(lane) ? 1 : 0;
  return size;
}

template <class Block>
std::uint64_t count_distinct_triangles(const Buffer<Block>& blocks) {
  std::vector<bool> seen;
  std::uint64_t count = 0;
  for (const Block& block : blocks)
    for (std::uint32_t lane = 0; lane < kBlockLanes && block.has(lane); ++lane)
      count += is_first(seen, block.prim_id[lane]) ? 1 : 0;
  return count;
}

void count_leaf(std::uint32_t size, std::uint32_t depth, Bvh8Stats& stats) {
  ++stats.leaves, stats.references += size;
  stats.depth = std::max(stats.depth, depth);
  count_in(stats.leaves_by_depth, depth);
  count_in(stats.leaves_by_size, std::min<std::size_t>(size, kLargestCountedLeaf));
}

}  // namespace

template <class Node>
Bvh8Stats bvh8_stats(const Bvh8Of<Node>& bvh, float traversal_cost, float intersection_cost) {
  Bvh8Stats stats;
  if (bvh.root == kNoNode) return stats;

  struct Visit {
    NodeRef ref;
    std::uint32_t depth;
    double area;
  };
  double cost = 0, children = 0, squared_size = 0;
  std::uint64_t blocks = 0;
  const double root_area = half_area_in_double(bvh.bounds);
  std::vector<Visit> pending{{bvh.root, 0, root_area}};
  while (!pending.empty()) {
    const Visit visit = pending.back();
    pending.pop_back();
    if (is_leaf(visit.ref)) {
      const std::uint32_t size = count_triangles(bvh.blocks, visit.ref), of_leaf = block_count(bvh.blocks, visit.ref);
      count_leaf(size, visit.depth, stats);
      squared_size += static_cast<double>(size) * size, blocks += of_leaf;
      cost += visit.area * intersection_cost * of_leaf;
      continue;
    }
    cost += visit.area * traversal_cost;
    ++stats.inner_nodes;
    const Node& node = bvh.nodes[visit.ref];
    for (std::uint32_t c = 0; c < kBvh8Arity && node.child[c] != kNoNode; ++c, ++children)
      pending.push_back({node.child[c], visit.depth + 1, half_area_in_double(node.bounds(c))});
  }
  const auto leaves = static_cast<double>(stats.leaves), references = static_cast<double>(stats.references);
  stats.sah_cost = root_area > 0 ? cost / root_area : 0.0;
  stats.mean_children = stats.inner_nodes > 0 ? children / static_cast<double>(stats.inner_nodes) : 0.0;
  stats.mean_leaf_size = references / leaves, stats.mean_block_size = references / static_cast<double>(blocks);
  stats.leaf_size_variance = std::max(0.0, squared_size / leaves - stats.mean_leaf_size * stats.mean_leaf_size);
  stats.triangles = count_distinct_triangles(bvh.blocks);
  return stats;
}

template Bvh8Stats bvh8_stats(const Bvh8&, float, float);
template Bvh8Stats bvh8_stats(const Bvh8Byte&, float, float);
template Bvh8Stats bvh8_stats(const Bvh8Half&, float, float);
template Bvh8Stats bvh8_stats(const Bvh8Compact&, float, float);

}  // namespace accel
