// Rounding-error bounds of single-precision arithmetic, with names in place of epsilons.
//
// Higham, Accuracy and Stability of Numerical Algorithms, section 3.1; the use in ray tracing follows Pharr, Jakob and
// Humphreys, Physically Based Rendering, section 6.8.
#pragma once

#include <cmath>
#include <limits>

namespace accel {

// Unit roundoff: half the distance from 1 to the next float. Every rounded operation has a relative error of at most this.
inline constexpr float kUnitRoundoff = std::numeric_limits<float>::epsilon() * 0.5f;

// The relative error of a product of n rounded factors is at most gamma(n) = n u / (1 - n u).
constexpr float gamma(int n) {
  return static_cast<float>(n) * kUnitRoundoff / (1.0f - static_cast<float>(n) * kUnitRoundoff);
}

// The neighbouring floats; infinities stay.
inline float next_up(float x) { return std::nextafter(x, std::numeric_limits<float>::infinity()); }
inline float next_down(float x) { return std::nextafter(x, -std::numeric_limits<float>::infinity()); }

// The largest float <= x, and the smallest float >= x.
inline float round_down(double x) {
  const float f = static_cast<float>(x);
  return static_cast<double>(f) > x ? next_down(f) : f;
}
inline float round_up(double x) {
  const float f = static_cast<float>(x);
  return static_cast<double>(f) < x ? next_up(f) : f;
}

}  // namespace accel
