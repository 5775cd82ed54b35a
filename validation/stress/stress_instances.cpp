#include "validation/stress/stress_instances.h"

#include <cmath>
#include <stdexcept>

#include "libaccel/core/counter_rng.h"
#include "libaccel/rays/ray_sets.h"
#include "validation/stress/stress_rays.h"
#include "validation/stress/stress_scenes.h"

namespace accel::validation {
namespace {

InstancedMeshes made(std::vector<TriangleMesh> meshes, std::vector<Instance> instances) {
  auto scene = InstancedMeshes::make(std::move(meshes), std::move(instances));
  if (!scene) throw std::runtime_error(scene.message());
  return *std::move(scene);
}

// Two triangles over the unit square, flat in y.
TriangleMesh square() { return mesh_of({{{0, 0, 0}, {1, 0, 0}, {1, 0, 1}}, {{0, 0, 0}, {1, 0, 1}, {0, 0, 1}}}); }

Vec3 random_point(CounterRng& rng, float reach) {
  const float x = rng.next_float(-reach, reach), y = rng.next_float(-reach, reach), z = rng.next_float(-reach, reach);
  return {x, y, z};
}

// `count` instances of two meshes, with scales of either sign between 1 / spread and spread, in a cube of +-reach.
InstancedMeshes scattered(std::uint32_t count, float spread, float reach, std::uint64_t seed) {
  std::vector<Instance> instances;
  for (std::uint32_t i = 0; i < count; ++i) {
    CounterRng rng(seed, i, 1);
    const auto scale = [&] {
      const float size = std::pow(spread, rng.next_float(-1, 1));
      return rng.next_below(4) == 0 ? -size : size;
    };
    const Vec3 scales{scale(), scale(), scale()};
    instances.push_back({i % 2, placed_at(random_point(rng, reach), scales, seed, i)});
  }
  return made({mesh_of(random_triangles(40, 0.4f, seed)), mesh_of(random_triangles(90, 0.2f, seed + 1))}, instances);
}

}  // namespace

Affine placed_at(Vec3 translation, Vec3 scale, std::uint64_t seed, std::uint64_t element) {
  CounterRng rng(seed, element, 2);
  // A unit quaternion from four numbers: uniform enough.
  double q[4], length = 0;
  for (double& x : q) x = rng.next_double() - 0.5, length += x * x;
  for (double& x : q) x /= std::sqrt(length);
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  const double r[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
                          {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
                          {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}};
  Affine result;
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b) result.m[a][b] = static_cast<float>(r[a][b] * scale[b]);
    result.m[a][3] = translation[a];
  }
  return result;
}

std::vector<InstancedScene> instanced_scenes(std::uint64_t seed) {
  const TriangleMesh one = mesh_of({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0.5f}}});
  const TriangleMesh soup = mesh_of(random_triangles(60, 0.3f, seed + 7));
  const TriangleMesh empty = mesh_of({});
  const Affine here, there = placed_at({0.3f, 0.2f, -0.1f}, {1, 1, 1}, seed, 99);
  Affine huge, tiny;
  for (int a = 0; a < 3; ++a) huge.m[a][a] = 1e3f, tiny.m[a][a] = 1e-3f;
  huge.m[0][3] = -500.0f;
  const Affine mirrored{{{-1, 0, 0, 0.5f}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
  return {{"nothing", made({}, {})},
          {"one triangle", made({one}, {{0, there}})},
          {"identity", made({soup}, {{0, here}})},
          {"coincident", made({soup}, {{0, there}, {0, there}, {0, there}})},
          {"overlapping and mirrored", made({soup}, {{0, here}, {0, there}, {0, mirrored}})},
          {"huge, tiny and empty", made({soup, empty}, {{1, huge}, {0, huge}, {1, here}, {0, tiny}, {0, here}, {1, tiny}})},
          {"floors",
           made({square()}, {{0, here}, {0, here}, {0, mirrored}, {0, Affine{{{3, 0, 0, -1}, {0, 1, 0, 0}, {0, 0, 3, -1}}}}})},
          {"scattered", scattered(50, 3, 4, seed)},
          {"stretched", scattered(30, 50, 4, seed + 2)},
          {"far away", scattered(20, 2, 3000, seed + 4)}};
}

std::vector<Ray> instance_rays(const InstancedMeshes& scene, std::size_t count, std::uint64_t seed) {
  const TriangleMesh flat = *scene.flattened();
  std::vector<Ray> rays = stress_rays(flat, count / 2, seed);
  const auto aimed = edge_rays(flat, count - rays.size(), seed);
  rays.insert(rays.end(), aimed->rays.begin(), aimed->rays.end());
  return rays;
}

}  // namespace accel::validation
