// Writes a leaf stream (structure/triangle_leaf.h), quad by quad.
#pragma once

#include <cstring>

#include "libaccel/geometry/triangle_mesh.h"
#include "libaccel/structure/triangle_leaf.h"

namespace accel {

// Both return where the next quad goes.
inline LeafQuad* write_triangle(const TriangleMesh& mesh, std::uint32_t prim_id, LeafQuad* at) {
  const PackedTriangle packed = pack(mesh.triangle(prim_id), prim_id);
  std::memcpy(at, &packed, sizeof packed);
  return at + kQuadsPerTriangle;
}
inline LeafQuad* write_end_of_leaf(LeafQuad* at) {
  *at = LeafQuad{{0, 0, 0}, kEndOfLeaf};
  return at + 1;
}

}  // namespace accel
