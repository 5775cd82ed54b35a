// What two levels of BVHs are like: those over meshes taken together, each once, and the predicted cost of the whole.
#pragma once

#include "libaccel/structure/bvh2_stats.h"
#include "libaccel/structure/bvh8_stats.h"
#include "libaccel/structure/two_level.h"
#include "libaccel/structure/two_level_bvh8.h"

namespace accel {

// `Stats` are those of one tree.
template <class Stats>
struct TwoLevelStats {
  // The SAH cost of a random long ray that meets the box of the scene: in the tree over instances, a leaf costs what the trees
  // of its instances cost. (A ray through an instance's box need not meet its mesh's, so this is an upper estimate.)
  double sah_cost = 0;
  Stats instances;  // of the tree over instances
  Stats meshes;     // sums over the others; means are over all of their leaves, and sah_cost is left out
};

// One pass over a valid structure. O(n), and a bit for each prim_id of a mesh.
TwoLevelStats<Bvh2Stats> two_level_stats(const TwoLevelBvh& bvh, float traversal_cost, float intersection_cost);
TwoLevelStats<Bvh8Stats> two_level_stats(const TwoLevelBvh8& bvh, float traversal_cost, float intersection_cost);

}  // namespace accel
