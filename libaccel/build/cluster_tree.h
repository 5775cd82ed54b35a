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

#include "libaccel/build/build_context.h"
#include "libaccel/build/cluster.h"
#include "libaccel/core/buffer.h"

namespace accel {

inline constexpr std::uint32_t kReach = 8;

// Adds inner nodes behind the `leaves` first clusters, which has room for them: leaves - 1, children before parents, the root
// last. `leaves` > 0. Stops early where the progress says so.
void merge_clusters(BuildContext& context, Buffer<Cluster>& clusters, std::size_t leaves, const Box4& bounds,
                    ProgressMeter& progress);

}  // namespace accel
