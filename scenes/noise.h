// Smooth random functions of space: gradient noise on a hashed lattice, and fractal sums of it.
//
// Perlin 2002, "Improving Noise": quintic fade, gradients towards the edges of a cube. Deviation: gradients are drawn by
// hashing the lattice point with the seed (libaccel/core/counter_rng.h), so there is no period and every seed is another field.
#pragma once

#include <cstdint>

#include "libaccel/core/vec3d.h"

namespace accel {

// In about [-1, 1], 0 at lattice points, continuous to the second derivative.
double noise(Vec3d p, std::uint64_t seed);

// The sum of `octaves` noises, each of twice the frequency and half the amplitude of the one before. In about [-2, 2].
double fractal_noise(Vec3d p, int octaves, std::uint64_t seed);

// Mountains: sharp ridges where the noise is 0, with detail that grows with height (Musgrave's ridged multifractal). In about
// [0, 2].
double ridged_noise(Vec3d p, int octaves, std::uint64_t seed);

}  // namespace accel
