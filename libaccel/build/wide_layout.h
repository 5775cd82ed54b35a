// From chosen forests to a Bvh8: which subtrees of a binary tree become children of which wide node, and where nodes and blocks
// are.
//
// Inner children of a node follow each other, and so do the blocks of its leaves; what is below them comes after, depth first.
// So all that is below one node is one run of nodes and one of blocks. Such pieces are made in parallel, with references
// relative to their beginnings, and then moved to where the sizes of those before them say.
#pragma once

#include "libaccel/build/wide_forests.h"
#include "libaccel/core/buffer.h"
#include "libaccel/structure/bvh2.h"
#include "libaccel/structure/bvh8.h"

namespace accel {

inline std::uint32_t blocks_for(std::uint32_t triangles) { return (triangles + kBlockLanes - 1) / kBlockLanes; }

// `forests` are those of the binary nodes; the tree is not empty. The same bytes for any number of threads. Fails when blocks
// or nodes outgrow the bits of a reference. O(n). May throw std::bad_alloc.
Result<Bvh8> lay_out_wide(const Bvh2& bvh, const Buffer<WideForests>& forests);

// The most memory that it took, its result included, the arguments not.
std::uint64_t wide_layout_peak_bytes(const Bvh8& wide);

}  // namespace accel
