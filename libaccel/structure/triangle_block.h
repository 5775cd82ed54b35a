// Triangles in blocks of four, coordinates by lane: what one ray tests with one stream of instructions.
//
// vertex[axis][i][lane] is a coordinate of vertex i of the triangle in a lane. A block has at least one triangle, in lane 0,
// and no gaps: lanes that are left over are behind, have NaN for coordinates, which no test accepts, and kNoHit for a prim_id.
//
// Four, not eight: leaves hold few triangles, and with eight lanes more than half would be empty.
#pragma once

#include <cstdint>
#include <limits>
#include <type_traits>

#include "libaccel/core/hit.h"
#include "libaccel/geometry/packed_triangle.h"

namespace accel {

inline constexpr std::uint32_t kBlockLanes = 4;

struct alignas(32) TriangleBlock {
  static constexpr bool kIsIndexed = false;  // it has the coordinates, and names no vertices

  float vertex[3][3][kBlockLanes];
  std::uint32_t prim_id[kBlockLanes];

  ACCEL_HD PackedTriangle packed(std::uint32_t lane) const {
    PackedTriangle t;
    for (int a = 0; a < 3; ++a) t.axis[a] = {{vertex[a][0][lane], vertex[a][1][lane], vertex[a][2][lane]}, 0};
    t.axis[0].word = prim_id[lane];
    return t;
  }
  void set(std::uint32_t lane, const PackedTriangle& t) {
    for (int a = 0; a < 3; ++a)
      for (int i = 0; i < 3; ++i) vertex[a][i][lane] = t.axis[a].vertex[i];
    prim_id[lane] = t.prim_id();
  }
  void clear(std::uint32_t lane) {
    constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
    set(lane, {{{{kNaN, kNaN, kNaN}, kNoHit}, {{kNaN, kNaN, kNaN}, 0}, {{kNaN, kNaN, kNaN}, 0}}});
  }
  ACCEL_HD bool has(std::uint32_t lane) const { return prim_id[lane] != kNoHit; }
};
static_assert(sizeof(TriangleBlock) == 40 * kBlockLanes && std::is_trivially_copyable_v<TriangleBlock>);

}  // namespace accel
