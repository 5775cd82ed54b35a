// Changes of the input whose effect on the answer is known: powers of two, the order of the triangles, unions.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "libaccel/core/counter_rng.h"
#include "validation/conformance/method_test.h"
#include "validation/stress/stress_rays.h"
#include "validation/stress/stress_scenes.h"

namespace accel::validation {
namespace {

class Metamorphic : public MethodTest {};

Vec3 scaled(Vec3 v, int k) { return {std::ldexp(v.x, k), std::ldexp(v.y, k), std::ldexp(v.z, k)}; }

TriangleMesh scaled(const TriangleMesh& mesh, int k) {
  TriangleMesh result{Buffer<Vec3>::copy_of(mesh.vertices.span()), mesh.triangles};
  for (Vec3& v : result.vertices) v = scaled(v, k);
  return result;
}

// The determinant of Moeller and Trumbore's test grows with the third power of the scale, so its range is smaller.
std::vector<int> exponents(bool watertight) {
  return watertight ? std::vector{-40, -13, -1, 1, 6, 40} : std::vector{-8, -1, 1, 8};
}

// Scaling the scene and the origins by 2^k scales t; scaling the directions as well leaves t alone. No other bit changes.
TEST_P(Metamorphic, PowersOfTwoScaleExactly) {
  for (const StressScene& scene : stress_scenes()) {
    // Features of 2^-40 leave the range of the watertight test when they are scaled by 2^-40 (geometry/watertight.h);
    // coordinates at the limit leave the library's.
    if (scene.name == "nested" || scene.name == "broken") continue;
    const std::vector<Ray> rays = stress_rays(scene.mesh, 500, 21);
    const std::vector<Hit> hits = closest(build(scene.mesh), rays);
    for (const int k : exponents(is_watertight())) {
      const AnyAccel accel = build(scaled(scene.mesh, k));
      std::vector<Ray> both = rays, scene_only = rays;
      for (std::size_t i = 0; i < rays.size(); ++i) {
        scene_only[i].org = both[i].org = scaled(rays[i].org, k);
        both[i].dir = scaled(rays[i].dir, k);
      }
      std::vector<Hit> expected = hits;
      EXPECT_TRUE(closest(accel, both) == expected) << scene.name << " times 2^" << k;
      for (Hit& hit : expected) hit.t = std::ldexp(hit.t, k);
      EXPECT_TRUE(closest(accel, scene_only) == expected) << scene.name << " times 2^" << k << ", directions unchanged";
    }
  }
}

// The order of the triangles decides ties only: the lowest number wins.
TEST_P(Metamorphic, OrderOfTrianglesDoesNotMatter) {
  for (const StressScene& scene : stress_scenes()) {
    std::vector<std::uint32_t> original(scene.mesh.size());  // the number that triangle i had
    std::iota(original.begin(), original.end(), 0u);
    CounterRng rng(1, 0);
    for (std::uint32_t i = static_cast<std::uint32_t>(original.size()); i > 1; --i)
      std::swap(original[i - 1], original[rng.next_below(i)]);
    TriangleMesh shuffled{scene.mesh.vertices, Buffer<IndexTriple>(scene.mesh.size())};
    for (std::size_t i = 0; i < original.size(); ++i) shuffled.triangles[i] = scene.mesh.triangles[original[i]];

    const std::vector<Ray> rays = stress_rays(scene.mesh, 1000, 22);
    const std::vector<Hit> before = closest(build(scene.mesh), rays);
    std::vector<Hit> after = closest(build(shuffled), rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      if (!after[i].valid()) continue;
      const std::uint32_t prim_id = original[after[i].prim_id];
      const bool tie = before[i].valid() && prim_id != before[i].prim_id && after[i].t == before[i].t;
      if (tie) {
        EXPECT_LT(before[i].prim_id, prim_id) << scene.name << ", ray " << i << ": the lowest number did not win";
        after[i] = before[i];
      } else {
        after[i].prim_id = prim_id;
      }
    }
    expect_same(scene.name, Judge(scene.mesh), rays, after, before);
  }
}

// The hit of a union is the nearer one of the parts' hits.
TEST_P(Metamorphic, UnionsHitTheNearerPart) {
  const std::vector<Triangle> first = random_triangles(200, 0.3f, 31), second = random_triangles(300, 0.2f, 32);
  std::vector<Triangle> all = first;
  all.insert(all.end(), second.begin(), second.end());
  const TriangleMesh mesh = mesh_of(all);
  const std::vector<Ray> rays = stress_rays(mesh, 3000, 23);
  const std::vector<Hit> in_first = closest(build(mesh_of(first)), rays), in_second = closest(build(mesh_of(second)), rays);
  std::vector<Hit> expected = in_first;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (!(in_second[i].t < in_first[i].t)) continue;
    expected[i] = in_second[i];
    expected[i].prim_id += static_cast<std::uint32_t>(first.size());
  }
  expect_same("union", Judge(mesh), rays, closest(build(mesh), rays), expected);
}

// Turning a triangle around moves its u and v, not its t.
TEST_P(Metamorphic, WindingDoesNotMatter) {
  if (!is_watertight()) GTEST_SKIP() << "Moeller and Trumbore's test rounds its three edges in different ways";
  const std::vector<Triangle> triangles = random_triangles(300, 0.3f, 33);
  std::vector<Triangle> turned = triangles;
  for (Triangle& t : turned) std::swap(t.v1, t.v2);
  const TriangleMesh mesh = mesh_of(triangles);
  const std::vector<Ray> rays = stress_rays(mesh, 2000, 24);
  const std::vector<std::uint8_t> before = occluded(build(mesh), rays), after = occluded(build(mesh_of(turned)), rays);
  std::size_t different = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) different += before[i] != after[i];
  EXPECT_EQ(different, 0u);
}

}  // namespace

ACCEL_FOR_EVERY_METHOD(Metamorphic);

}  // namespace accel::validation
