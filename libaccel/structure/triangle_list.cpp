#include "libaccel/structure/triangle_list.h"

#include <string>

namespace accel {

Status validate(const TriangleList& list, std::uint64_t triangle_count) {
  const std::uint64_t quads = list.leaves.size();
  if (quads % kQuadsPerTriangle != 1)
    return Error{"triangle list has " + std::to_string(quads) + " quads, which is not three a triangle and a terminator"};
  for (std::uint64_t quad = 0; quad + 1 < quads; quad += kQuadsPerTriangle) {
    const std::uint32_t prim_id = list.leaves[quad].word;
    if (prim_id >= triangle_count)
      return Error{"triangle list names triangle " + std::to_string(prim_id) + " at quad " + std::to_string(quad) +
                   ", but there are " + std::to_string(triangle_count)};
  }
  if (list.leaves[quads - 1].word != kEndOfLeaf) return Error{"triangle list has no terminator at its end"};
  return Done{};
}

}  // namespace accel
