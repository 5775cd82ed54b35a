// Localized intersection with queues against single rays; what it costs: exec/simt_localized_test.cpp.
#include "libaccel/packet/localized_warp.h"

#include <gtest/gtest.h>

#include <cstring>

#include "libaccel/exec/drive.h"
#include "libaccel/exec/simt_lanes.h"
#include "libaccel/trace/bvh2_stack.h"
#include "scenes/procedural.h"
#include "validation/unit/packet/localized_tasks.h"

namespace accel {
namespace {

// A warp that works all tasks off. Returns the most pairs that were in the queue.
template <Query kQuery, std::uint32_t kRaysInHand, class Answer>
std::uint32_t run(const LocalizedTasks& tasks, std::vector<Answer>& answers) {
  if (!answers.empty()) std::memset(static_cast<void*>(answers.data()), 0xab, answers.size() * sizeof(Answer));
  LocalizedMemory<kRaysInHand> memory;
  SimtLanes lanes(0, tasks.count);
  LocalizedWarp<Watertight, kQuery, kRaysInHand, SimtLanes, Answer> warp(tasks, answers.data(), memory, lanes);
  std::uint32_t most = 0;
  warp.begin();
  while (warp.step()) {
    most = std::max(most, warp.waiting_pairs());
    EXPECT_LT(warp.waiting_pairs(), 2 * kLanes);
    EXPECT_LE(warp.waiting_boxes(), kRaysInHand);
  }
  EXPECT_EQ(warp.waiting_pairs() + warp.waiting_boxes(), 0u);
  return most;
}

template <std::uint32_t kRaysInHand>
void expect_hits_of_single_rays(const Bvh2& tree, const test::TaskArrays& arrays, std::size_t& valid) {
  const LocalizedTasks tasks = arrays.view(tree);
  const std::size_t n = arrays.rays.size();
  std::vector<Hit> expected(n), stack(n), hits(n);
  std::vector<std::uint8_t> blocked(n), occluded(n);
  NullObserver observer;
  for (const LocalizedTask& task : arrays.tasks) {
    expected[task.ray] = arrays.alone<Query::closest>(tree, task, observer);
    stack[task.ray] = trace_ray<Bvh2Stack<Watertight, Query::closest>>(tree.view(), arrays.rays[task.ray], observer);
    blocked[task.ray] = arrays.alone<Query::any>(tree, task, observer).valid();
    valid += blocked[task.ray];
  }
  run<Query::closest, kRaysInHand>(tasks, hits);
  EXPECT_EQ(std::memcmp(hits.data(), expected.data(), n * sizeof(Hit)), 0);
  EXPECT_EQ(std::memcmp(hits.data(), stack.data(), n * sizeof(Hit)), 0);
  run<Query::any, kRaysInHand>(tasks, occluded);
  EXPECT_EQ(occluded, blocked);
}

TEST(LocalizedWarp, HitsAreThoseOfSingleRays) {
  std::size_t valid = 0;
  for (const auto& [name, mesh] : validation::stress_scenes()) {
    SCOPED_TRACE(name);
    const Bvh2 tree = test::octo_tree(mesh);
    if (tree.octo.empty()) continue;
    const test::TaskArrays arrays(mesh, tree, 11);
    expect_hits_of_single_rays<kLocalizedRaysInHand>(tree, arrays, valid);
    expect_hits_of_single_rays<32>(tree, arrays, valid);
  }
  EXPECT_GT(valid, 1000u);
}

TEST(LocalizedWarp, HitsAreThoseOfSingleRaysInBuiltInScenes) {
  std::size_t valid = 0;
  for (const char* name : {"soup:2000", "stadium:3000", "colonnade:3000", "slivers:500"}) {
    SCOPED_TRACE(name);
    const auto scene = make_builtin(name);
    ASSERT_TRUE(scene) << scene.message();
    const Bvh2 tree = test::octo_tree(scene->mesh);
    expect_hits_of_single_rays<kLocalizedRaysInHand>(tree, test::TaskArrays(scene->mesh, tree, 12), valid);
  }
  EXPECT_GT(valid, 500u);
}

// The fullest that the queue of pairs can be: it has 31 when 32 boxes are tested, and all are entered.
TEST(LocalizedWarp, PairsReachTheirBound) {
  const auto scene = make_builtin("soup:2000");
  ASSERT_TRUE(scene) << scene.message();
  const Bvh2 tree = test::octo_tree(scene->mesh);
  std::uint32_t most = 0;
  for (const std::uint64_t seed : {1, 2, 3}) {
    const test::TaskArrays arrays(scene->mesh, tree, seed);
    std::vector<Hit> hits(arrays.rays.size());
    most = std::max(most, run<Query::closest, kLocalizedRaysInHand>(arrays.view(tree), hits));
  }
  EXPECT_GT(most, 48u);
}

TEST(LocalizedWarp, NoTasksNoSteps) {
  std::vector<Hit> hits;
  EXPECT_EQ((run<Query::closest, 32>(LocalizedTasks{}, hits)), 0u);
}

}  // namespace
}  // namespace accel
