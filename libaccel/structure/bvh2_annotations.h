// The part of validate() that concerns what a Bvh2 may have beyond nodes and leaves.
#pragma once

#include "libaccel/structure/bvh2.h"

namespace accel {

// Proves that links, hash tables, skip pointers and octo nodes are those that the tree implies, whatever their bytes are. The tree itself,
// root, nodes and leaves, must have been proved. O(nodes + quads).
Status check_annotations(const Bvh2& bvh);

}  // namespace accel
