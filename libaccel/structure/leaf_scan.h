// Reads a leaf stream of unknown origin from its start and says where leaves begin: the part of validation that structures
// share.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "libaccel/core/result.h"
#include "libaccel/structure/triangle_leaf.h"

namespace accel {

struct LeafScan {
  std::vector<bool> is_start;  // for each quad
  std::uint64_t leaves = 0;
  std::uint64_t references = 0;
};

// Proves that the stream is a sequence of leaves, none empty, all terminated, with every prim_id < triangle_count. O(n).
Result<LeafScan> scan_leaves(std::span<const LeafQuad> stream, std::uint64_t triangle_count);

}  // namespace accel
