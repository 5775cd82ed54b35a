// Floats that many tests name.
#pragma once

#include <limits>

namespace accel {

inline constexpr float kInfinity = std::numeric_limits<float>::infinity();
inline constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

}  // namespace accel
