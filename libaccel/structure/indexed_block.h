// Triangles in blocks of four whose vertices are elsewhere, each once: a line of 64 bytes a block, and 12 bytes a vertex.
//
// As Embree's compact mode has it: leaves that name vertices. A triangle in the middle of a mesh shares each of its vertices
// with five others, so that a block costs less than half of one that has the coordinates (structure/triangle_block.h).
//
// vertex[i][lane] is vertex i of the triangle in a lane, as an index of the array of vertices that comes with the blocks. Lanes
// that are left over are behind, as in a TriangleBlock: kNoHit for a prim_id, and vertices whose coordinates are NaN, so that
// whoever fetches a block need not ask which lanes there are. Vectors of 16 bytes are loaded where a vertex begins: the last
// vertex of the array is there to be read over, and no block names it.
#pragma once

#include <cstdint>
#include <type_traits>

#include "libaccel/structure/triangle_block.h"

namespace accel {

struct alignas(64) IndexedBlock {
  static constexpr bool kIsIndexed = true;

  std::uint32_t vertex[3][kBlockLanes];
  std::uint32_t prim_id[kBlockLanes];

  ACCEL_HD PackedTriangle packed(std::uint32_t lane, const Vec3* vertices) const {
    const Vec3 v[3] = {vertices[vertex[0][lane]], vertices[vertex[1][lane]], vertices[vertex[2][lane]]};
    PackedTriangle t;
    for (int a = 0; a < 3; ++a) t.axis[a] = {{v[0][a], v[1][a], v[2][a]}, 0};
    t.axis[0].word = prim_id[lane];
    return t;
  }
  ACCEL_HD bool has(std::uint32_t lane) const { return prim_id[lane] != kNoHit; }
};
static_assert(sizeof(IndexedBlock) == 64 && std::is_trivially_copyable_v<IndexedBlock>);

}  // namespace accel
