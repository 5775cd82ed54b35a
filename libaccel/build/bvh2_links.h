// Annotates a Bvh2 with links in the padding of its nodes and the terminators of its leaves: parent and sibling as for Afra and
// Szirmay-Kalos 2014, or uncle and grand-uncle as in Binder and Keller 2016, Fig. 4 and 5 (structure/bvh2.h).
//
// There is room for one kind: links of another are replaced. Nodes and leaves are copied before they are changed, because
// structures share their arrays.
#pragma once

#include "libaccel/structure/bvh2.h"

namespace accel {

// O(nodes + quads); parallel in the calling thread's arena; throws std::bad_alloc.
void add_links(Bvh2& bvh, Bvh2Links kind);

}  // namespace accel
