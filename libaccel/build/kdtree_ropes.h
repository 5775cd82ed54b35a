// Annotates a kd-tree with ropes: Popov, Guenther, Seidel and Slusallek 2007, "Stackless KD-Tree Traversal for High Performance
// GPU Ray Tracing", on their construction and optimisation.
//
// Ropes are handed down: a child's rope through the plane that divides it from its sibling is the sibling, its other ropes are
// its parent's. At every node each rope is lowered to the smallest subtree that still holds all leaves behind the node's face,
// before it is handed on.
#pragma once

#include "libaccel/structure/kdtree.h"

namespace accel {

// Sets tree.ropes. O(nodes * depth) at worst, in practice O(nodes); parallel in the calling thread's arena; throws
// std::bad_alloc.
void add_ropes(KdTree& tree);

}  // namespace accel
