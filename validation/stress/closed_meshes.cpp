#include "validation/stress/closed_meshes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/mesh_builder.h"
#include "scenes/noise.h"

namespace accel::validation {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr double kTubeRadius = 0.45;

// Uniform enough in the unit ball.
Vec3d in_ball(CounterRng& rng) {
  Vec3d p;
  do {
    const double x = rng.next_double(), y = rng.next_double(), z = rng.next_double();
    p = Vec3d{x, y, z} * 2 - Vec3d{1, 1, 1};
  } while (dot(p, p) > 1);
  return p;
}

Vec3d on_sphere(CounterRng& rng) {
  for (;;) {
    const Vec3d p = in_ball(rng);
    if (dot(p, p) > 0.01) return normalized(p);
  }
}

// A sphere whose radius depends on the direction.
template <class Radius>
ClosedMesh star(std::string name, std::uint64_t triangles, const Radius& radius) {
  const auto frequency = static_cast<std::uint32_t>(std::sqrt(static_cast<double>(triangles) / 8));
  MeshBuilder builder;
  builder.add_sphere(std::max(2u, frequency), [=](Vec3d unit) { return unit * radius(unit); });
  return {std::move(name), builder.build(), 0, 0.2};
}

ClosedMesh torus(std::string name, std::uint32_t columns, std::uint32_t rows) {
  MeshBuilder builder;
  builder.add_grid(columns, rows, GridShape::torus, [](double u, double v) {
    const double r = 1 + kTubeRadius * std::cos(kTwoPi * v);
    return Vec3d{r * std::cos(kTwoPi * u), r * std::sin(kTwoPi * u), kTubeRadius * std::sin(kTwoPi * v)};
  });
  return {std::move(name), builder.build(), 1, 0.1};
}

}  // namespace

Vec3d ClosedMesh::inside(CounterRng& rng) const {
  const double angle = kTwoPi * rng.next_double();
  return Vec3d{std::cos(angle), std::sin(angle), 0} * ring_radius + in_ball(rng) * inside_radius;
}

Vec3d ClosedMesh::outside(CounterRng& rng) const { return on_sphere(rng) * (2.5 + 4 * rng.next_double()); }

std::vector<ClosedMesh> closed_meshes(std::uint64_t triangles, std::uint64_t seed) {
  const auto side = std::max(16u, static_cast<std::uint32_t>(std::sqrt(static_cast<double>(triangles) / 4)));
  std::vector<ClosedMesh> meshes;
  meshes.push_back(star("sphere", triangles, [](Vec3d) { return 1.0; }));
  meshes.push_back(torus("torus", 2 * side, side));
  meshes.push_back(star("displaced", triangles, [=](Vec3d unit) {
    const double height = 0.35 * fractal_noise(unit * 2.5, 4, seed);
    return 1 + std::clamp(height, -0.5, 0.6);
  }));
  // Neighbouring vertices up to a fifth of the radius apart: silhouettes everywhere, dihedral angles of all sizes.
  meshes.push_back(star("bumpy", triangles, [=](Vec3d unit) {
    const auto lattice = [](double x) { return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(x * 0x1p20))); };
    CounterRng rng(seed, mix_bits(lattice(unit.x) * 0x10001 + mix_bits(lattice(unit.y)) + 3 * lattice(unit.z)));
    return 0.9 + 0.2 * rng.next_double();
  }));
  // Edges of 0.5 beside edges of 0.01 and less.
  meshes.push_back(torus("slivers", 12, std::max(48u, static_cast<std::uint32_t>(triangles / 24))));
  return meshes;
}

TriangleMesh placed(const TriangleMesh& mesh, const Placement& placement) {
  TriangleMesh result{Buffer<Vec3>::copy_of(mesh.vertices.span()), mesh.triangles};
  for (Vec3& v : result.vertices) v = placement(Vec3d(v)).to_float();
  return result;
}

}  // namespace accel::validation
