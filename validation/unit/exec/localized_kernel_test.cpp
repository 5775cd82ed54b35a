// The source of the kernel of localized intersection on the CPU's emulated warps, against single rays. What a device does: see
// cuda_test.cpp.
#include <gtest/gtest.h>

#include <cstring>

#include "scenes/procedural.h"
#include "validation/unit/exec/warp_emulator.h"
#include "validation/unit/packet/localized_tasks.h"
// The kernel needs the emulator's intrinsics.
#include "libaccel/exec/cuda/localized_kernel.cuh"

namespace accel {
namespace {

template <Query kQuery, class Answer>
void expect_answers_of_single_rays(const Bvh2& tree, const test::TaskArrays& arrays) {
  std::vector<Answer> expected(arrays.rays.size()), answers(arrays.rays.size());
  NullObserver observer;
  for (const LocalizedTask& task : arrays.tasks) store_answer(arrays.alone<kQuery>(tree, task, observer), expected[task.ray]);
  std::memset(static_cast<void*>(answers.data()), 0xab, answers.size() * sizeof(Answer));
  std::uint32_t next_task = 0;
  run_warps(1, [&] { cuda::localized_kernel<Watertight, kQuery, Answer>(arrays.view(tree), answers.data(), &next_task); });
  EXPECT_EQ(std::memcmp(answers.data(), expected.data(), answers.size() * sizeof(Answer)), 0);
  EXPECT_GE(next_task, arrays.tasks.size());
}

TEST(LocalizedKernel, AnswersAreThoseOfSingleRays) {
  const auto scene = make_builtin("soup:100");
  ASSERT_TRUE(scene) << scene.message();
  const Bvh2 tree = test::octo_tree(scene->mesh);
  test::TaskArrays arrays(scene->mesh, tree, 31);
  ASSERT_GT(arrays.tasks.size(), 333u);
  for (const std::size_t count : {333, 32, 1}) {
    // From the end, where packets are small.
    arrays.tasks.erase(arrays.tasks.begin(), arrays.tasks.end() - static_cast<std::ptrdiff_t>(count));
    // Rays that are in no task are nobody's.
    std::vector<Ray> rays;
    for (LocalizedTask& task : arrays.tasks)
      rays.push_back(arrays.rays[task.ray]), task.ray = static_cast<std::uint32_t>(rays.size() - 1);
    arrays.rays = rays;
    expect_answers_of_single_rays<Query::closest, Hit>(tree, arrays);
    expect_answers_of_single_rays<Query::any, std::uint8_t>(tree, arrays);
  }
}

}  // namespace
}  // namespace accel
