// Sample patterns: cells of equal area on the unit square, and directions on spheres.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include "libaccel/core/counter_rng.h"
#include "libaccel/core/vec3d.h"

namespace accel {

struct UnitPoint {
  double x, y;  // in [0, 1]
};

// A random point in cell `index` of `count` cells of equal area that tile the unit square: about sqrt(count) rows, each as high
// as its share of the cells and cut into cells of equal width.
inline UnitPoint point_in_cell(std::uint32_t index, std::uint32_t count, CounterRng& rng) {
  const auto rows = static_cast<std::uint64_t>(std::sqrt(static_cast<double>(count)));
  const std::uint64_t row = ((std::uint64_t{index} + 1) * rows - 1) / count;
  const std::uint64_t first = row * count / rows, end = (row + 1) * count / rows;
  const double x = rng.next_double(), y = rng.next_double();
  const double cells = static_cast<double>(end - first);
  return {(static_cast<double>(index - first) + x) / cells, (static_cast<double>(first) + y * cells) / count};
}

// A direction about the unit vector n with a density of cos / pi: a uniform point on the disk, raised to the hemisphere
// (Malley). The cosine is at least 2^-12, so that rounding to floats does not tilt the direction below the surface.
inline Vec3d cosine_direction(Vec3d n, CounterRng& rng) {
  const double radius_2 = rng.next_float(), angle = 2 * std::numbers::pi * rng.next_double();
  const double radius = std::sqrt(radius_2);
  Vec3d tangent, bitangent;
  make_basis(n, tangent, bitangent);
  return tangent * (radius * std::cos(angle)) + bitangent * (radius * std::sin(angle)) + n * std::sqrt(1 - radius_2);
}

// A direction uniform on the unit sphere.
inline Vec3d sphere_direction(CounterRng& rng) {
  const double z = 2 * rng.next_double() - 1, angle = 2 * std::numbers::pi * rng.next_double();
  const double radius = std::sqrt(std::fmax(0.0, 1 - z * z));
  return {radius * std::cos(angle), radius * std::sin(angle), z};
}

}  // namespace accel
