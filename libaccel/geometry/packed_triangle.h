// A triangle as leaves store it: three quads of 16 bytes, coordinates by axis.
//
// axis[a].vertex[i] is coordinate a of vertex i, so one 16-byte load brings one coordinate of all three vertices: what a ray's
// axis permutation (Woop et al. 2013) and SIMD want. axis[0].word is the caller's prim_id; the other two words are zero.
#pragma once

#include <cstdint>
#include <type_traits>

#include "libaccel/geometry/triangle_mesh.h"

namespace accel {

struct alignas(16) PackedTriangle {
  struct alignas(16) Quad {
    float vertex[3];
    std::uint32_t word;
  };
  Quad axis[3];

  ACCEL_HD std::uint32_t prim_id() const { return axis[0].word; }
  ACCEL_HD Vec3 vertex(int i) const { return {axis[0].vertex[i], axis[1].vertex[i], axis[2].vertex[i]}; }

  // Coordinate `a` of all vertices, and all coordinates: what the triangle tests read, in as few loads as there can be.
  ACCEL_HD Quad coordinate(int a) const { return load_16_bytes(axis[a]); }
  ACCEL_HD Triangle vertices() const {
    const Quad x = coordinate(0), y = coordinate(1), z = coordinate(2);
    return {{x.vertex[0], y.vertex[0], z.vertex[0]},
            {x.vertex[1], y.vertex[1], z.vertex[1]},
            {x.vertex[2], y.vertex[2], z.vertex[2]}};
  }
};
static_assert(sizeof(PackedTriangle) == 48 && std::is_trivially_copyable_v<PackedTriangle>);

inline PackedTriangle pack(const Triangle& t, std::uint32_t prim_id) {
  return {{{{t.v0.x, t.v1.x, t.v2.x}, prim_id}, {{t.v0.y, t.v1.y, t.v2.y}, 0}, {{t.v0.z, t.v1.z, t.v2.z}, 0}}};
}

}  // namespace accel
