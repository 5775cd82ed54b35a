// Instances in SIMD lanes against their scalar twin, on every target that the machine has.
#include "libaccel/trace/bvh8_instances_simd.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "libaccel/exec/drive.h"
#include "libaccel/trace/bvh8_instances.h"
#include "validation/stress/stress_instances.h"
#include "validation/stress/stress_rays.h"
#include "validation/unit/build/built_instances.h"
#include "validation/unit/trace/simd_batches.h"

namespace accel {
namespace {

using test::built;

std::vector<Ray> rays_for(const InstancedMeshes& scene) {
  std::vector<Ray> rays = validation::instance_rays(scene, 1000, 5);
  for (const Ray& ray : validation::invalid_rays()) rays.push_back(ray);
  for (std::size_t i = 0; i < rays.size(); i += 3) rays[i].t_max = 0.5f;
  for (std::size_t i = 1; i < rays.size(); i += 5) rays[i].t_min = i % 2 == 0 ? 0.1f : -1.0f;
  return rays;
}

// Returns how many rays hit something.
std::size_t expect_same_as_scalar(const std::string& name, const InstancedMeshes& scene, const BuildOptions& options) {
  const TwoLevelBvh8 bvh = built<WideInstances>(scene, options);
  const std::vector<Ray> rays = rays_for(scene);
  std::vector<Hit> expected;
  std::vector<std::uint8_t> blocked;
  std::size_t valid = 0;
  NullObserver observer;
  for (const Ray& ray : rays) {
    expected.push_back(trace_ray<Bvh8Instances<Watertight, Query::closest>>(bvh.view(), ray, observer));
    blocked.push_back(trace_ray<Bvh8Instances<Watertight, Query::any>>(bvh.view(), ray, observer).valid() ? 1 : 0);
    valid += expected.back().valid();
  }
  test::on_every_target([&] {
    std::vector<Hit> hits(rays.size(), Hit{1, 2, 3, 4});
    std::vector<std::uint8_t> occluded(rays.size(), 7);
    const auto functions = Bvh8InstancesSimd<Watertight>::functions();
    test::trace_in_batches<TwoLevelBvh8View, Hit>(functions, bvh.view(), rays, hits);
    test::trace_in_batches<TwoLevelBvh8View, std::uint8_t>(functions, bvh.view(), rays, occluded);
    std::size_t different = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) different += test::same(hits[i], expected[i]) ? 0 : 1;
    EXPECT_EQ(different, 0u) << name << ' ' << bvh8_simd_target();
    EXPECT_EQ(occluded, blocked) << name << ' ' << bvh8_simd_target();
  });
  return valid;
}

TEST(Bvh8InstancesSimd, HitsAreThoseOfTheScalarTwin) {
  std::size_t valid = 0;
  for (const auto& s : validation::instanced_scenes(5)) valid += expect_same_as_scalar(s.name, s.scene, {});
  EXPECT_GT(valid, 1000u);
}

// And so are those of runs of instances, and of trees that are leaves.
TEST(Bvh8InstancesSimd, InLeavesOfManyInstances) {
  for (const auto& s : validation::instanced_scenes(6))
    for (const int depth : {0, 1}) expect_same_as_scalar(s.name, s.scene, {.max_depth = depth});
}

}  // namespace
}  // namespace accel
