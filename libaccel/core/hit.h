// What a ray meets.
#pragma once

#include <cstdint>
#include <limits>
#include <type_traits>

#include "libaccel/core/vec3.h"

namespace accel {

inline constexpr std::uint32_t kNoHit = 0xffffffffu;

// The nearest intersection of a ray. prim_id is the caller's triangle number, or kNoHit.
//
// The point is org + t * dir, and (1 - u - v) * v0 + u * v1 + v * v2. Where several triangles are met at the same t, the one
// with the lowest prim_id is named, so that hits do not depend on the order of tests, nor ever on the number of threads. They
// depend on the structure, and on the way that a traversal takes through it, only where rounding moves a hit out of the box
// that holds its triangle: where the ray passes the triangle by a hair, or sees it edge-on. A miss has t = +infinity and u = v
// = 0.
struct alignas(16) Hit {
  float t = std::numeric_limits<float>::infinity();
  float u = 0.0f, v = 0.0f;
  std::uint32_t prim_id = kNoHit;

  ACCEL_HD bool valid() const { return prim_id != kNoHit; }
};
static_assert(sizeof(Hit) == 16 && std::is_trivially_copyable_v<Hit>, "files and devices rely on this layout");

// Which hit a query asks for. `any` stops at the first triangle that the ray meets; only hit or miss is then meaningful.
enum class Query : std::uint8_t { closest, any };

}  // namespace accel
