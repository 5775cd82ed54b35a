#include "libaccel/structure/leaf_scan.h"

#include <string>

namespace accel {

Result<LeafScan> scan_leaves(std::span<const LeafQuad> stream, std::uint64_t triangle_count) {
  LeafScan scan;
  scan.is_start.resize(stream.size());
  std::size_t quad = 0;
  while (quad < stream.size()) {
    const std::string leaf = "leaf at quad " + std::to_string(quad);
    const std::size_t first = quad;
    scan.is_start[first] = true, ++scan.leaves;
    for (; quad < stream.size() && stream[quad].word != kEndOfLeaf; quad += kQuadsPerTriangle, ++scan.references)
      if (stream[quad].word >= triangle_count)
        return Error{leaf + " names triangle " + std::to_string(stream[quad].word) + ", but there are " +
                     std::to_string(triangle_count)};
    if (quad >= stream.size()) return Error{leaf + " has no terminator"};
    if (quad == first) return Error{leaf + " is empty"};
    ++quad;
  }
  return scan;
}

}  // namespace accel
