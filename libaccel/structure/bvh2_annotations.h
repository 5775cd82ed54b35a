// The part of validate() that concerns what a Bvh2 may have beyond nodes and leaves.
#pragma once

#include "libaccel/structure/bvh2.h"

namespace accel {

// Proves that links, hash tables and skip pointers are those that the tree implies, whatever their bytes are, and that the octo
// nodes lead to every leaf of the tree once, by its own box; boxes of inner octo nodes are, like those of the tree, not proved.
// The tree itself, root, nodes and leaves, must have been proved. O(nodes + quads).
Status check_annotations(const Bvh2& bvh);

}  // namespace accel
