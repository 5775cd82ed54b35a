// Floats that hurt: magnitudes over many exponents, and the special values.
#pragma once

#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>

#include "libaccel/core/counter_rng.h"
#include "libaccel/core/vec3.h"

namespace accel::validation {

// Of either sign, with a magnitude in [2^lowest, 2^(highest + 1)) whose exponent is uniform.
inline float random_over_exponents(CounterRng& rng, int lowest, int highest) {
  const int exponent = lowest + static_cast<int>(rng.next_below(static_cast<std::uint32_t>(highest - lowest + 1)));
  const float magnitude = std::ldexp(1.0f + rng.next_float(), exponent);
  return (rng.next_u64() & 1) != 0 ? -magnitude : magnitude;
}

// Zeros, ones, the ends of the normal, denormal and finite ranges, infinities and NaN.
inline constexpr float kSpecialFloats[] = {0.0f,
                                           -0.0f,
                                           1.0f,
                                           -1.0f,
                                           std::numeric_limits<float>::denorm_min(),
                                           -std::numeric_limits<float>::denorm_min(),
                                           std::numeric_limits<float>::min(),
                                           -std::numeric_limits<float>::min(),
                                           std::numeric_limits<float>::max(),
                                           -std::numeric_limits<float>::max(),
                                           std::numeric_limits<float>::infinity(),
                                           -std::numeric_limits<float>::infinity(),
                                           std::numeric_limits<float>::quiet_NaN()};

// A special value in one of `rarity` draws, otherwise any exponent that floats have.
inline float hostile_float(CounterRng& rng, std::uint32_t rarity = 4) {
  if (rng.next_below(rarity) == 0) return kSpecialFloats[rng.next_below(std::size(kSpecialFloats))];
  return random_over_exponents(rng, -140, 127);
}

inline Vec3 hostile_vec3(CounterRng& rng, std::uint32_t rarity = 4) {
  const float x = hostile_float(rng, rarity), y = hostile_float(rng, rarity), z = hostile_float(rng, rarity);
  return {x, y, z};
}

// Uniform in the cube [-extent, extent]^3.
inline Vec3 random_in_cube(CounterRng& rng, float extent) {
  const float x = rng.next_float(-extent, extent), y = rng.next_float(-extent, extent), z = rng.next_float(-extent, extent);
  return {x, y, z};
}

}  // namespace accel::validation
