// What a Bvh2 is like: predicted cost, overlap, shape and size.
//
// SAH cost: Goldsmith and Salmon 1987, MacDonald and Booth 1990. The cost of a random long ray that meets the root's box: the
// sum over inner nodes of traversal_cost * area(node) / area(root), plus the sum over leaves of intersection_cost * triangles *
// area(leaf) / area(root).
//
// EPO, end-point overlap: Aila, Karras and Laine 2013, "On Quality Metrics of Bounding Volume Hierarchies", section 4. How much
// of the scene's surface lies in nodes that it does not belong to, where rays that end on it descend for nothing: the sum over
// nodes of cost(node) * area(surface of triangles outside of the node's subtree, in the node's box) / area(all surface).
// Deviation: a triangle that spatial splits gave to several leaves belongs to every subtree that has a part of it.
//
// The paper's third metric, leaf-count variability, is a property of a tree and a set of rays; what is reported here is the
// variance of leaf sizes, under its own name.
#pragma once

#include <cstdint>
#include <vector>

#include "libaccel/structure/bvh2.h"

namespace accel {

struct Bvh2Stats {
  double sah_cost = 0;
  std::uint64_t inner_nodes = 0;
  std::uint64_t leaves = 0;
  std::uint64_t triangles = 0;   // each counted once
  std::uint64_t references = 0;  // in the leaves
  std::uint32_t depth = 0;       // inner nodes on the longest path
  double mean_leaf_depth = 0;    // inner nodes above a leaf
  double mean_leaf_size = 0;     // triangles
  double leaf_size_variance = 0;
  std::vector<std::uint64_t> leaves_by_depth;  // [d]: leaves below d inner nodes
  std::vector<std::uint64_t> leaves_by_size;   // [n]: leaves with n triangles; the last entry counts all larger ones too
  std::uint64_t node_bytes = 0, leaf_bytes = 0;

  // References beyond one a triangle, as a share of the triangles.
  double duplication() const {
    return triangles > 0 ? static_cast<double>(references - triangles) / static_cast<double>(triangles) : 0.0;
  }
};

// The last entry of leaves_by_size.
inline constexpr std::size_t kLargestCountedLeaf = 32;

// One pass over a valid tree, without recursion. O(n), and a bit for each prim_id.
Bvh2Stats bvh2_stats(const Bvh2& bvh, float traversal_cost, float intersection_cost);

// The end-point overlap of a valid tree. Each triangle is clipped along the paths of all nodes that it reaches into: O(n) times
// the nodes that overlap a triangle, several microseconds a triangle, on all threads. `stride` > 1 measures every stride-th
// triangle only, which estimates the sum without bias from their order. The result does not depend on the number of threads.
double end_point_overlap(const Bvh2& bvh, float traversal_cost, float intersection_cost, std::uint32_t stride = 1);

}  // namespace accel
