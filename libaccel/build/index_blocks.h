// From blocks of triangles with coordinates to blocks that name vertices (structure/indexed_block.h).
//
// Vertices are merged where all bits of their positions are the same, whatever the mesh's own indices are: tests see the bits
// that they saw. -0 is kept apart from 0. The order is that of their first use in the blocks, so that a leaf's vertices are
// near to each other and to those of the next leaf.
//
// Corners are sorted by a hash of their positions, so that those to be merged follow each other. O(n), in parallel, and the
// same for any number of threads.
#pragma once

#include "libaccel/core/buffer.h"
#include "libaccel/core/vec3.h"
#include "libaccel/structure/indexed_block.h"

namespace accel {

struct IndexedBlocks {
  Buffer<IndexedBlock> blocks;
  Buffer<Vec3> vertices;  // and one more, to be read over; none where there are no blocks
};

// There are at most kMaxBlocks of them. May throw std::bad_alloc.
IndexedBlocks index_blocks(const Buffer<TriangleBlock>& blocks);

// What that holds beside the blocks and the result: for each corner its hash, its number and the first corner there, and what
// sorting needs.
constexpr std::uint64_t indexing_bytes(std::size_t blocks) { return std::uint64_t{20} * 3 * kBlockLanes * blocks; }

}  // namespace accel
