// Random triangles in a cube. Their sizes spread over a factor of 2^10, around the mean distance of neighbours, so that the
// number of triangles that a ray passes grows slowly with their count.
#include <cmath>

#include "libaccel/core/counter_rng.h"
#include "scenes/generators.h"
#include "scenes/mesh_builder.h"

namespace accel {
namespace {

Vec3d point_in_cube(CounterRng& rng) {
  const double x = 2 * rng.next_double() - 1, y = 2 * rng.next_double() - 1, z = 2 * rng.next_double() - 1;
  return {x, y, z};
}

}  // namespace

SceneData make_soup(std::uint64_t size, std::uint64_t seed) {
  const double spacing = 2 / std::cbrt(static_cast<double>(size));
  const auto vertex = [=](std::uint32_t i) {
    CounterRng triangle(seed, i / 3), corner(seed, i, 1);
    const Vec3d center = point_in_cube(triangle);
    const double reach = spacing * std::exp2(-7 + 10 * triangle.next_double());
    return center + point_in_cube(corner) * std::fmin(reach, 0.5);
  };
  MeshBuilder builder;
  builder.add(3 * size, size, vertex, [](std::uint32_t i) { return IndexTriple{3 * i, 3 * i + 1, 3 * i + 2}; });
  return {builder.build(), {{{1.7f, 1.3f, 3.4f}, {0, 0, 0}, {0, 1, 0}, 40, "default"}}, {}};
}

}  // namespace accel
