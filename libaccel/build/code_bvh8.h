// Codes the boxes of a Bvh8 in few bits: see structure/bvh8_coded.h.
//
// Each axis of a node's frame begins at the lowest plane of its children and has the least exponent for which the largest code
// reaches the highest. Parallel over nodes, the same bytes for any number of threads; O(n). The leaves' blocks are shared or,
// for a layout whose blocks name vertices, made from those that there are (build/index_blocks.h).
#pragma once

#include "libaccel/structure/bvh8_coded.h"

namespace accel {

// Node is ByteBvh8Node, HalfBvh8Node or CompactBvh8Node. May throw std::bad_alloc.
template <class Node>
Bvh8Of<Node> code_bvh8(const Bvh8& bvh);

}  // namespace accel
