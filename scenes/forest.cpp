// A wood on hilly ground: many instances of a conifer, a broad-leaved tree and a boulder, turned, leaning, stretched, and one
// in four mirrored. The ground is an instance too, of itself.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "libaccel/core/counter_rng.h"
#include "scenes/generators.h"
#include "scenes/mesh_builder.h"
#include "scenes/noise.h"

namespace accel {
namespace {

constexpr double kGroundSide = 120;     // metres
constexpr double kGroundShare = 0.05;   // of all triangles
constexpr double kPlantsPerRoot = 0.7;  // plants: this times the square root of the triangles

double ground_at(double x, double z, std::uint64_t seed) { return 4 * fractal_noise(Vec3d{x * 0.02, 0.5, z * 0.02}, 5, seed); }

TriangleMesh make_ground(double triangles, std::uint64_t seed) {
  const std::uint32_t n = steps_for(triangles, 2);
  MeshBuilder builder;
  builder.add_grid(n, n, GridShape::open, [=](double u, double v) {
    const double x = kGroundSide * (u - 0.5), z = kGroundSide * (0.5 - v);
    return Vec3d{x, ground_at(x, z, seed), z};
  });
  return builder.build();
}

// Eight metres: a trunk, and tiers of twigs that droop.
TriangleMesh make_conifer(double triangles) {
  const auto tiers = static_cast<std::uint32_t>(std::clamp(std::sqrt(triangles) / 6, 2.0, 12.0));
  std::vector<ProfilePoint> profile{{0.25, 0}, {0.15, 1}};
  for (std::uint32_t i = 0; i < tiers; ++i) {
    const double share = static_cast<double>(i) / tiers, next = (i + 1.0) / tiers;
    profile.push_back({2.2 * (1 - share) + 0.1, 1 + 7 * share});
    profile.push_back({0.12 * (1 - next) + 0.03, 1 + 7 * (next - 0.15 / tiers)});
  }
  const double rows = static_cast<double>(profile.size() - 1);
  MeshBuilder builder;
  builder.add_lathe({}, profile, std::max(3u, static_cast<std::uint32_t>(std::lround(triangles / (2 * rows)))));
  return builder.build();
}

// Six metres: a trunk and five balls of leaves.
TriangleMesh make_broadleaf(double triangles, std::uint64_t seed) {
  MeshBuilder builder;
  builder.add_lathe({}, {{0.35, 0}, {0.2, 1.5}, {0.15, 4}}, std::max(3u, static_cast<std::uint32_t>(triangles / 40)));
  constexpr std::array<Vec3d, 5> kBalls{{{0, 4.6, 0}, {1.1, 3.9, 0.3}, {-0.9, 3.8, 0.7}, {0.2, 3.7, -1.2}, {-0.3, 3.4, -0.2}}};
  for (std::size_t i = 0; i < kBalls.size(); ++i) {
    const double radius = i == 0 ? 1.4 : 1.1;
    builder.add_sphere(steps_for(0.9 * triangles / kBalls.size(), 8),
                       [=](Vec3d d) { return kBalls[i] + d * (radius * (1 + 0.25 * noise(d * 5, seed + i))); });
  }
  return builder.build();
}

TriangleMesh make_boulder(double triangles, std::uint64_t seed) {
  MeshBuilder builder;
  builder.add_sphere(steps_for(triangles, 8), [=](Vec3d d) { return d * (0.8 + 0.3 * fractal_noise(d * 1.5, 4, seed)); });
  return builder.build();
}

// A place for one plant: anywhere, turned about the vertical and leaning by some degrees, stretched by up to a half.
Affine plant_at(std::uint64_t seed, std::uint64_t element, bool is_boulder) {
  CounterRng rng(seed, element, 1);
  const auto draw = [&](double lo, double hi) { return lo + (hi - lo) * rng.next_double(); };
  const double x = draw(-0.5, 0.5) * kGroundSide, z = draw(-0.5, 0.5) * kGroundSide;
  const double size = is_boulder ? draw(0.2, 1.5) : draw(0.6, 1.4), turn = draw(0, 2 * std::numbers::pi);
  const double mirror = rng.next_below(4) == 0 ? -1 : 1;
  const double scale[3] = {mirror * size * draw(0.7, 1.3), size * draw(0.8, 1.5), size * draw(0.7, 1.3)};
  const double lean_x = draw(-0.08, 0.08), lean_z = draw(-0.08, 0.08), c = std::cos(turn), s = std::sin(turn);
  // The vertical leans by a shear, which no rotation makes.
  const double linear[3][3] = {{c, lean_x, s}, {0, 1, 0}, {-s, lean_z, c}};
  Affine place;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) place.m[a][b] = static_cast<float>(linear[a][b] * scale[b]);
  place.m[0][3] = static_cast<float>(x), place.m[2][3] = static_cast<float>(z);
  place.m[1][3] = static_cast<float>(ground_at(x, z, seed) - (is_boulder ? 0 : 0.1));
  return place;
}

}  // namespace

SceneData make_forest(std::uint64_t size, std::uint64_t seed) {
  const double wanted = static_cast<double>(size), for_plants = wanted * (1 - kGroundShare);
  const double plant_size = for_plants / std::max(1.0, std::round(kPlantsPerRoot * std::sqrt(wanted)));
  std::vector<TriangleMesh> meshes{make_ground(wanted * kGroundShare, seed), make_conifer(plant_size),
                                   make_broadleaf(plant_size, seed), make_boulder(plant_size, seed)};

  // Half conifers, a third broad-leaved, the rest boulders, until there are enough triangles.
  constexpr std::uint32_t kKinds[6] = {1, 2, 1, 3, 2, 1};
  std::vector<Instance> instances{{0, Affine{}}};
  double left = for_plants;
  for (std::uint64_t i = 0; left > 0; ++i) {
    const std::uint32_t mesh = kKinds[i % 6];
    instances.push_back({mesh, plant_at(seed, i, mesh == 3)});
    left -= static_cast<double>(meshes[mesh].size());
  }
  const float eye = static_cast<float>(ground_at(0, 0.62 * kGroundSide, seed));
  const CameraDescription camera{{0, eye + 12, 0.62f * kGroundSide}, {0, 2, 0}, {0, 1, 0}, 50, "default"};
  // The generator makes no instance that could be refused.
  return {{}, {camera}, {}, *InstancedMeshes::make(std::move(meshes), std::move(instances))};
}

}  // namespace accel
