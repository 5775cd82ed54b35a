// Whether two hits are the same: t bit for bit, u and v but for the sign of zeros.
#pragma once

#include <bit>
#include <cstdint>

#include "libaccel/core/hit.h"

namespace accel::validation {

inline bool same_hit(const Hit& a, const Hit& b) {
  return std::bit_cast<std::uint32_t>(a.t) == std::bit_cast<std::uint32_t>(b.t) && a.u == b.u && a.v == b.v &&
         a.prim_id == b.prim_id;
}

}  // namespace accel::validation
