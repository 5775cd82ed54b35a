// What a Bvh8 is like: predicted cost, shape and size.
//
// The cost is that of structure/bvh2_stats.h, with steps and tests as they are made here: the sum over nodes of traversal_cost
// * area(node) / area(root), plus the sum over leaves of intersection_cost * blocks * area(leaf) / area(root).
#pragma once

#include <cstdint>
#include <vector>

#include "libaccel/structure/bvh8.h"

namespace accel {

struct Bvh8Stats {
  double sah_cost = 0;
  std::uint64_t inner_nodes = 0;
  std::uint64_t leaves = 0;
  std::uint64_t triangles = 0;   // each counted once
  std::uint64_t references = 0;  // in the leaves
  std::uint32_t depth = 0;       // inner nodes on the longest path
  double mean_children = 0;      // of an inner node
  double mean_leaf_size = 0;     // triangles
  double leaf_size_variance = 0;
  double mean_block_size = 0;                  // triangles
  std::vector<std::uint64_t> leaves_by_depth;  // [d]: leaves below d inner nodes
  std::vector<std::uint64_t> leaves_by_size;   // [n]: leaves with n triangles; the last entry counts all larger ones too
};

// One pass over a valid tree, without recursion. O(n), and a bit for each prim_id.
template <class Node>
Bvh8Stats bvh8_stats(const Bvh8Of<Node>& bvh, float traversal_cost, float intersection_cost);

}  // namespace accel
