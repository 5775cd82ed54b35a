// Rounding-error bounds of single-precision arithmetic, with names in place of epsilons.
//
// Higham, Accuracy and Stability of Numerical Algorithms, section 3.1; the use in ray tracing follows Pharr, Jakob and
// Humphreys, Physically Based Rendering, section 6.8.
#pragma once

#include <bit>
#include <cstdint>
#include <limits>

namespace accel {

// Unit roundoff: half the distance from 1 to the next float. Every rounded operation has a relative error of at most this.
inline constexpr float kUnitRoundoff = std::numeric_limits<float>::epsilon() * 0.5f;

// The relative error of a product of n rounded factors is at most gamma(n) = n u / (1 - n u).
constexpr float gamma(int n) {
  return static_cast<float>(n) * kUnitRoundoff / (1.0f - static_cast<float>(n) * kUnitRoundoff);
}

// The neighbouring floats, as std::nextafter() has them; infinities that there is nothing beyond stay, and NaN does. Floats of
// one sign are in the order of their bits, so no call into the mathematical library is needed: builders round often.
constexpr float next_up(float x) {
  if (!(x < std::numeric_limits<float>::infinity())) return x;
  const auto bits = std::bit_cast<std::uint32_t>(x + 0.0f);  // zeros are positive
  return std::bit_cast<float>(x >= 0 ? bits + 1 : bits - 1);
}
constexpr float next_down(float x) { return -next_up(-x); }

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
