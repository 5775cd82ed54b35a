// What a KdTree is like: predicted cost, shape and size.
//
// Expected cost: MacDonald and Booth 1990; Wald and Havran 2006, section 3. The cost of a random long ray that meets the tree's
// box: inner nodes and triangle tests, each weighted with the area of its cell as a share of the whole. Rays that end at their
// hits need less; the numbers compare trees over one scene.
#pragma once

#include <cstdint>
#include <vector>

#include "libaccel/structure/kdtree.h"

namespace accel {

struct KdTreeStats {
  double expected_steps = 0;  // inner nodes of a random line
  double expected_leaves = 0;
  double expected_tests = 0;  // triangles
  std::uint64_t inner_nodes = 0;
  std::uint64_t leaves = 0;
  std::uint64_t empty_leaves = 0;              // of them
  std::uint64_t triangles = 0;                 // each counted once
  std::uint64_t references = 0;                // in the leaves
  std::uint32_t depth = 0;                     // inner nodes on the longest path
  double mean_leaf_depth = 0;                  // inner nodes above a leaf
  double mean_leaf_size = 0;                   // references of a leaf that is not empty
  double leaf_size_variance = 0;               // of these
  std::vector<std::uint64_t> leaves_by_depth;  // [d]: leaves below d inner nodes
  std::vector<std::uint64_t> leaves_by_size;   // [n]: leaves with n references; the last entry counts all larger ones too

  double sah_cost(double traversal_cost, double intersection_cost) const {
    return traversal_cost * expected_steps + intersection_cost * expected_tests;
  }
  double references_per_triangle() const {
    return triangles > 0 ? static_cast<double>(references) / static_cast<double>(triangles) : 0.0;
  }
};

// The last entry of leaves_by_size.
inline constexpr std::size_t kLargestCountedKdLeaf = 32;

// One pass over a valid tree, without recursion. O(n).
KdTreeStats kdtree_stats(const KdTree& tree);

}  // namespace accel
