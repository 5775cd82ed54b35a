#include "scenes/noise.h"

#include <algorithm>
#include <cmath>

#include "libaccel/core/counter_rng.h"

namespace accel {
namespace {

// The hashed gradient of lattice point (x, y, z) times the offset d: one of the 12 directions to the edges of a cube.
double gradient(std::int64_t x, std::int64_t y, std::int64_t z, Vec3d d, std::uint64_t seed) {
  const auto word = [](std::int64_t i) { return static_cast<std::uint64_t>(i); };
  const std::uint64_t hash =
      mix_bits(word(x) * 0x9e3779b97f4a7c15ull + mix_bits(word(y) * 0xc2b2ae3d27d4eb4full + mix_bits(word(z) + seed)));
  const std::uint64_t edge = (hash >> 32) * 12 >> 32;
  const double a = edge < 4 ? d.y : d.x, b = edge < 8 ? d.z : d.y;
  return (edge & 1 ? -a : a) + (edge & 2 ? -b : b);
}

double fade(double t) { return t * t * t * (t * (t * 6 - 15) + 10); }
double mix(double a, double b, double t) { return a + (b - a) * t; }

}  // namespace

double noise(Vec3d p, std::uint64_t seed) {
  const Vec3d cell{std::floor(p.x), std::floor(p.y), std::floor(p.z)};
  const Vec3d d = p - cell;
  const auto x = static_cast<std::int64_t>(cell.x), y = static_cast<std::int64_t>(cell.y),
             z = static_cast<std::int64_t>(cell.z);
  const auto corner = [&](int i, int j, int k) { return gradient(x + i, y + j, z + k, d - Vec3d(i, j, k), seed); };
  const double u = fade(d.x), v = fade(d.y), w = fade(d.z);
  const double front = mix(mix(corner(0, 0, 0), corner(1, 0, 0), u), mix(corner(0, 1, 0), corner(1, 1, 0), u), v);
  const double back = mix(mix(corner(0, 0, 1), corner(1, 0, 1), u), mix(corner(0, 1, 1), corner(1, 1, 1), u), v);
  return mix(front, back, w);
}

double fractal_noise(Vec3d p, int octaves, std::uint64_t seed) {
  double sum = 0, scale = 1;
  for (int i = 0; i < octaves; ++i, scale *= 2) sum += noise(p * scale, seed + static_cast<std::uint64_t>(i)) / scale;
  return sum;
}

double ridged_noise(Vec3d p, int octaves, std::uint64_t seed) {
  double sum = 0, scale = 1, weight = 1;
  for (int i = 0; i < octaves; ++i, scale *= 2) {
    const double ridge = 1 - std::fabs(noise(p * scale, seed + static_cast<std::uint64_t>(i)));
    const double signal = ridge * ridge * weight;
    sum += signal / scale;
    weight = std::clamp(2 * signal, 0.0, 1.0);
  }
  return sum;
}

}  // namespace accel
