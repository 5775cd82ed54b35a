// From a binary tree of clusters to one with eight children a node, at the least cost.
//
// The costs and choices are those of build/collapse_wide.h, but that leaves are as they are: a block each. The nodes that one
// round of merging made know nothing of each other, so that all choose at once.
//
// Nodes come level by level, and those of a level in the order of their parents, so that all of a level are found at once and
// inner children follow each other. A leaf is the block with its own number. O(n), in parallel; the same for any number of
// threads.
#pragma once

#include <optional>

#include "libaccel/build/builder.h"
#include "libaccel/build/cluster_tree.h"
#include "libaccel/core/buffer.h"
#include "libaccel/structure/bvh8.h"

namespace accel {

struct WideNodes {
  Buffer<Bvh8Node> nodes;
  NodeRef root = kNoNode;
  std::uint32_t depth = 0;
};

// Nothing, if it is deeper than max_depth.
std::optional<WideNodes> collapse_clusters(const ClusterTree& tree, const BuildOptions& options);

// What the collapse held beside the clusters.
std::uint64_t collapse_clusters_bytes(const ClusterTree& tree, const WideNodes& wide);

}  // namespace accel
