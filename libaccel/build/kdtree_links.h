// Annotates a kd-tree with what kd-backtrack reads (trace/kdtree_backtrack.h): of each inner node its parent and its cell,
// stored by the pair of its children (structure/kdtree.h).
#pragma once

#include "libaccel/structure/kdtree.h"

namespace accel {

// Sets tree.parents and tree.cells. O(nodes); parallel in the calling thread's arena; throws std::bad_alloc.
void add_links(KdTree& tree);

}  // namespace accel
