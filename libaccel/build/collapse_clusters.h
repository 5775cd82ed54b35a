// From a binary tree of clusters to one with eight children a node, fast.
//
// The child with the largest area is replaced by its own two until there are eight: what Embree's and other fast builders do.
// The tree of build/collapse_wide.h is cheaper, and takes longer to find.
//
// Nodes come level by level, and those of a level in the order of their parents, so that all of a level are made at once and
// inner children follow each other. A leaf is the block with its own number. O(n); the same for any number of threads.
#pragma once

#include <optional>
#include <vector>

#include "libaccel/build/cluster.h"
#include "libaccel/core/buffer.h"
#include "libaccel/structure/bvh8.h"

namespace accel {

struct WideNodes {
  std::vector<Bvh8Node> nodes;
  NodeRef root = kNoNode;
  std::uint32_t depth = 0;
};

// Of the tree whose root is the last of 2 leaves - 1 clusters (build/cluster_tree.h). Nothing, if it is deeper than max_depth.
std::optional<WideNodes> collapse_clusters(const Buffer<Cluster>& clusters, std::size_t leaves, std::uint32_t max_depth);

}  // namespace accel
