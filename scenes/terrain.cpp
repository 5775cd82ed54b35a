// A mountain range: 10 x 10 km, some 1500 m high, one connected height field. Ridges from noise, valleys where a low plain cuts
// them.
#include <algorithm>
#include <cmath>

#include "scenes/generators.h"
#include "scenes/mesh_builder.h"
#include "scenes/noise.h"

namespace accel {
namespace {

constexpr double kTerrainSide = 10'000, kHeight = 1'500;  // metres
constexpr int kOctaves = 11;                              // down to some metres

double height_at(double u, double v, std::uint64_t seed) {
  const Vec3d p{3 * u, 0.37, 3 * v};
  const double mountains = ridged_noise(p, kOctaves, seed);
  const double plain = 0.5 + 0.5 * fractal_noise(p * 0.6, 3, seed + 1000);
  return kHeight * (mountains * std::clamp(plain, 0.0, 1.0) + 0.02 * fractal_noise(p * 8, 4, seed + 2000));
}

}  // namespace

SceneData make_terrain(std::uint64_t size, std::uint64_t seed) {
  const std::uint32_t n = steps_for(static_cast<double>(size), 2);
  MeshBuilder builder;
  builder.add_grid(n, n, GridShape::open, [=](double u, double v) {
    return Vec3d{kTerrainSide * (u - 0.5), height_at(u, v, seed), kTerrainSide * (0.5 - v)};
  });
  return {builder.build(), {{{1500, 2700, 5200}, {0, 500, 0}, {0, 1, 0}, 45, "default"}}, {}};
}

}  // namespace accel
