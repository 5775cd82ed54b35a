// Merges clusters along a curve into a binary tree, bottom up.
//
// Meister and Bittner 2018, "Parallel Locally-Ordered Clustering for Bounding Volume Hierarchy Construction" (PLOC): in every
// round each cluster looks for the neighbour with which it has the smallest box, at most kReach places away on the curve; where
// two choose each other they become one, in the place of the first.
//
// Deviations. Pairs with equal areas are ordered by the exclusive or of their places: it is the same seen from both, and of
// many equal clusters every other one finds its partner, where an order by place would merge one pair a round. Boxes that grow
// along the curve have the same effect (each cluster prefers the one before): a round that merges few merges neighbours two by
// two instead, so that there are O(log n) rounds for any input.
//
// The same for any number of threads. O(n kReach).
#pragma once

#include <vector>

#include "libaccel/build/build_context.h"
#include "libaccel/build/cluster.h"
#include "libaccel/core/buffer.h"

namespace accel {

// Measured: from 2 to 8, trees over leaves of four triangles get dearer as often as cheaper, and take longer. The paper, which
// merges single triangles, uses 10 to 100.
inline constexpr std::uint32_t kReach = 2;

struct ClusterTree {
  Buffer<Cluster> clusters;         // leaves, then inner nodes, children before parents; the root is the last of 2 leaves - 1
  std::size_t leaves = 0;           // in the order of a curve
  std::vector<std::size_t> rounds;  // the first node of each round, and one behind the last
};

// Adds the inner nodes to a tree that has leaves, at least one, and room for 2 leaves - 1 clusters. Stops early where the
// progress says so.
void merge_clusters(BuildContext& context, ClusterTree& tree, const Box4& bounds, ProgressMeter& progress);

}  // namespace accel
