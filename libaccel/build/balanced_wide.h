// A tree with eight children a node over references in an order that is given, of parts that are as equal as they can be: for
// trees that would otherwise be too deep.
//
// No deeper than max_depth: where that is reached, a leaf takes what there is. O(n).
#pragma once

#include <vector>

#include "libaccel/build/collapse_clusters.h"
#include "libaccel/build/references.h"

namespace accel {

// References that make a block. A run of none is the end of a leaf that needs one (structure/bvh8.h).
struct BlockRun {
  std::uint32_t first, count;
};

WideNodes balanced_wide(const Buffer<Reference>& sorted, const BuildOptions& options, std::vector<BlockRun>& runs);

}  // namespace accel
