// Needles: triangles whose length is 10 to 10^6 times their height. Their boxes are nearly empty and their edge functions
// cancel.
#include <cmath>
#include <numbers>

#include "libaccel/core/counter_rng.h"
#include "scenes/generators.h"
#include "scenes/mesh_builder.h"

namespace accel {
namespace {

Vec3d direction(CounterRng& rng) {
  const double z = 2 * rng.next_double() - 1, angle = 2 * std::numbers::pi * rng.next_double();
  const double radius = std::sqrt(1 - z * z);
  return {radius * std::cos(angle), radius * std::sin(angle), z};
}

// Corner 0, 1 or 2 of a needle: its ends, and a point off its axis somewhere along it.
Vec3d needle_corner(CounterRng rng, std::uint32_t corner) {
  const double x = 2 * rng.next_double() - 1, y = 2 * rng.next_double() - 1, z = 2 * rng.next_double() - 1;
  const double length = 0.1 * std::pow(10, rng.next_double());
  const double height = length * std::pow(10, -1 - 5 * rng.next_double());
  const Vec3d along = direction(rng), center{x, y, z};
  if (corner < 2) return center + along * (corner == 0 ? -length / 2 : length / 2);
  Vec3d side, other;
  make_basis(along, side, other);
  return center + along * (length * (rng.next_double() - 0.5)) + side * height;
}

}  // namespace

SceneData make_slivers(std::uint64_t size, std::uint64_t seed) {
  MeshBuilder builder;
  builder.add(
      3 * size, size, [=](std::uint32_t i) { return needle_corner(CounterRng(seed, i / 3), i % 3); },
      [](std::uint32_t i) {
        return IndexTriple{3 * i, 3 * i + 1, 3 * i + 2};
      });
  return {builder.build(), {{{1.7f, 1.3f, 3.4f}, {0, 0, 0}, {0, 1, 0}, 42, "default"}}, {}};
}

}  // namespace accel
