// What localized intersection with queues costs, against what its rays need.
#include "libaccel/exec/simt_localized.h"

#include <gtest/gtest.h>

#include "libaccel/exec/counters.h"
#include "libaccel/exec/simt.h"
#include "scenes/procedural.h"
#include "validation/unit/packet/localized_tasks.h"

namespace accel {
namespace {

struct LocalizedScene {
  Bvh2 tree;
  test::TaskArrays arrays;
};
LocalizedScene make_scene(const char* name) {
  const auto scene = make_builtin(name);
  EXPECT_TRUE(scene) << scene.message();
  Bvh2 tree = test::octo_tree(scene->mesh);
  test::TaskArrays arrays(scene->mesh, tree, 21);
  return {std::move(tree), std::move(arrays)};
}

// The tests that the rays make one by one.
template <Query kQuery>
Counters count_alone(const LocalizedScene& scene) {
  CountingObserver observer;
  for (const LocalizedTask& task : scene.arrays.tasks) scene.arrays.alone<kQuery>(scene.tree, task, observer);
  return observer.counters;
}

template <Query kQuery>
WarpProfile simulate(const LocalizedScene& scene, std::uint32_t rays_per_warp = 1024) {
  std::vector<Hit> hits(scene.arrays.rays.size());
  return simulate_localized<Watertight, kQuery, kLocalizedRaysInHand>(scene.arrays.view(scene.tree), hits.data(),
                                                                      rays_per_warp);
}

// Rays that hit nothing test the same boxes and triangles in any order: every pair of a ray and a leaf once.
template <Query kQuery>
void expect_every_test_once(LocalizedScene scene) {
  std::vector<LocalizedTask> misses;
  NullObserver observer;
  for (const LocalizedTask& task : scene.arrays.tasks)
    if (!scene.arrays.alone<kQuery>(scene.tree, task, observer).valid()) misses.push_back(task);
  ASSERT_GT(misses.size(), 100u);
  ASSERT_LT(misses.size(), scene.arrays.tasks.size());
  scene.arrays.tasks = misses;
  const Counters alone = count_alone<kQuery>(scene);
  const SimtProfile p = simulate<kQuery>(scene).simt;
  EXPECT_EQ(p.descend.active_lanes, alone.box_tests);
  EXPECT_EQ(p.intersect.active_lanes, alone.triangle_tests);
  EXPECT_EQ(p.fetch.active_lanes, misses.size());
}

TEST(SimtLocalized, RaysThatMissMakeEveryTestOnce) {
  expect_every_test_once<Query::closest>(make_scene("soup:500"));
  expect_every_test_once<Query::any>(make_scene("soup:500"));
  expect_every_test_once<Query::any>(make_scene("colonnade:3000"));
}

// Others make as many, and a few more; no more boxes than there are.
template <Query kQuery>
void expect_no_test_is_left_out(const LocalizedScene& scene) {
  const Counters alone = count_alone<kQuery>(scene);
  std::uint64_t all = 0;
  for (const LocalizedTask& task : scene.arrays.tasks)
    all += scene.arrays.firsts[task.active + 1] - scene.arrays.firsts[task.active];
  const SimtProfile p = simulate<kQuery>(scene).simt;
  EXPECT_GE(p.descend.active_lanes, alone.box_tests);
  EXPECT_LE(p.descend.active_lanes, all);
  EXPECT_LT(p.descend.active_lanes, alone.box_tests + alone.box_tests / 10);
  EXPECT_EQ(p.rays, scene.arrays.tasks.size());
  EXPECT_EQ(p.backtrack.steps, 0u);
  for (const auto& phase : {p.descend, p.intersect, p.fetch}) {
    EXPECT_GE(phase.steps * kWarpSize, phase.active_lanes);
    EXPECT_GE(phase.active_lanes, phase.steps);
  }
}

TEST(SimtLocalized, NoTestIsLeftOut) {
  expect_no_test_is_left_out<Query::closest>(make_scene("soup:2000"));
  expect_no_test_is_left_out<Query::any>(make_scene("soup:2000"));
  expect_no_test_is_left_out<Query::any>(make_scene("stadium:3000"));
}

// One ray alone: one lane of 32, and the steps are its tests.
TEST(SimtLocalized, OneRayIsOneLane) {
  LocalizedScene scene = make_scene("soup:500");
  scene.arrays.tasks.resize(1);
  const Counters alone = count_alone<Query::closest>(scene);
  const WarpProfile p = simulate<Query::closest>(scene);
  ASSERT_GT(alone.box_tests, 0u);
  EXPECT_EQ(p.simt.descend.efficiency(), 1.0 / 32);
  EXPECT_GE(p.simt.descend.active_lanes, alone.box_tests);
  EXPECT_EQ(p.simt.fetch.steps, 1u);
  EXPECT_EQ(p.simt.of(Memory::ray).bytes, sizeof(LocalizedTask) + sizeof(Ray) + sizeof(Hit));
}

// Copies of one ray fill all lanes, whichever packet they are said to be in, as long as there are rays to fetch.
TEST(SimtLocalized, LanesAreAtWorkOnRaysOfAnyPacket) {
  LocalizedScene scene = make_scene("soup:2000");
  const SimtProfile together = simulate<Query::closest>(scene, 1u << 20).simt, apart = simulate<Query::closest>(scene, 32).simt;
  EXPECT_GT(together.efficiency(), 0.95);
  EXPECT_LT(apart.efficiency(), together.efficiency());
  EXPECT_EQ(together.warps, 1u);
  EXPECT_EQ(apart.warps, (scene.arrays.tasks.size() + 31) / 32);
}

// What this is for: any-hit rays in packets, as lanes that are rays trace them, need more steps.
TEST(SimtLocalized, FewerStepsThanARayALane) {
  const LocalizedScene scene = make_scene("colonnade:3000");
  SimtProfile by_ray;
  for (std::size_t first = 0; first < scene.arrays.tasks.size();) {
    const std::uint32_t active = scene.arrays.tasks[first].active, places = scene.arrays.firsts[active];
    std::vector<Ray> rays;
    for (; first < scene.arrays.tasks.size() && scene.arrays.tasks[first].active == active; ++first)
      rays.push_back(scene.arrays.rays[scene.arrays.tasks[first].ray]);
    const PacketLeaves leaves{scene.tree.octo.data(), scene.tree.leaves.data(), scene.arrays.places.data() + places,
                              scene.arrays.firsts[active + 1] - places};
    by_ray += simulate_simt<LocalizedRay<Watertight, Query::any>>(leaves, rays, {}, {.schedule = SimtSchedule::if_while}, 1);
  }
  const SimtProfile queued = simulate<Query::any>(scene).simt;
  EXPECT_LT(queued.descend.steps + queued.intersect.steps, (by_ray.descend.steps + by_ray.intersect.steps) / 2);
}

}  // namespace
}  // namespace accel
