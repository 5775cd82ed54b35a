#include "libaccel/packet/breadth_first.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "libaccel/packet/cpu_primitives.h"
#include "libaccel/packet/culling_simd.h"
#include "libaccel/packet/serial_primitives.h"
#include "validation/unit/packet/packets_of_rays.h"

namespace accel {
namespace {

using test::Pairs;

struct Traversed {
  Pairs pairs;
  std::vector<std::uint8_t> gave_up;
};

template <class Primitives, class Culling, class Tree = OctoTree>
Traversed traverse(const Bvh2& tree, const std::vector<Frustum>& frustums, std::uint32_t budget = 1000000) {
  BreadthFirst<Primitives, Culling, Tree> traversal;
  std::vector<std::uint32_t> budgets(frustums.size(), budget);
  Traversed result{{}, std::vector<std::uint8_t>(frustums.size())};
  const auto& leaves = traversal.run(tree.view(), frustums.data(), frustums.size(), budgets.data(), result.gave_up.data());
  for (std::size_t i = 0; i < leaves.count; ++i) result.pairs.push_back({leaves.frustum[i], leaves.place[i]});
  return result;
}

struct Case {
  Bvh2 tree;
  std::vector<Frustum> frustums;
  Pairs expected;
};

std::vector<Case> cases() {
  std::vector<Case> result;
  for (const auto& [name, mesh] : validation::stress_scenes()) {
    Case test{test::octo_tree(mesh), {}, {}};
    if (test.tree.octo.empty()) continue;
    test.frustums = test::frustums_for(mesh, test.tree.bounds, 2);
    test.expected = test::walk<OctoTree>(test.tree, test.frustums);
    result.push_back(std::move(test));
  }
  return result;
}

TEST(BreadthFirst, FindsWhatADepthFirstWalkFindsInTheSameOrder) {
  std::size_t found = 0;
  for (const Case& test : cases()) {
    const Traversed serial = traverse<SerialPrimitives, ScalarCulling>(test.tree, test.frustums);
    EXPECT_EQ(serial.pairs, test.expected);
    EXPECT_THAT(serial.gave_up, testing::Each(0));
    EXPECT_EQ((traverse<CpuPrimitives, ScalarCulling>(test.tree, test.frustums).pairs), test.expected);
    EXPECT_EQ((traverse<SerialPrimitives, SimdCulling>(test.tree, test.frustums).pairs), test.expected);
    found += test.expected.size();
  }
  EXPECT_GT(found, 10000u);
}

TEST(BreadthFirst, TheBinaryTreeHasTheLeavesOfTheOctoTreeOrFewer) {
  std::size_t fewer = 0, all = 0;
  for (const Case& test : cases()) {
    const Pairs expected = test::walk<BinaryTree>(test.tree, test.frustums);
    EXPECT_EQ((traverse<SerialPrimitives, ScalarCullingOf<BinaryTree>, BinaryTree>(test.tree, test.frustums).pairs), expected);
    auto binary = test::leaves_of<BinaryTree>(test.tree, expected), octo = test::leaves_of<OctoTree>(test.tree, test.expected);
    std::sort(binary.begin(), binary.end()), std::sort(octo.begin(), octo.end());
    EXPECT_TRUE(std::includes(octo.begin(), octo.end(), binary.begin(), binary.end()));
    fewer += binary.size(), all += octo.size();
  }
  EXPECT_GT(fewer, all / 2);
}

TEST(BreadthFirst, FrustumsThatMeetTooMuchLeaveTheQueue) {
  std::ptrdiff_t stayed = 0;
  for (const Case& test : cases()) {
    for (const std::uint32_t budget : {0u, 1u, 10u}) {
      const Traversed limited = traverse<SerialPrimitives, SimdCulling>(test.tree, test.frustums, budget);
      Pairs expected;
      std::vector<std::uint32_t> met(test.frustums.size());
      for (const auto& [frustum, place] : test.expected) {
        ++met[frustum];
        if (limited.gave_up[frustum] == 0) expected.push_back({frustum, place});
      }
      EXPECT_EQ(limited.pairs, expected);
      for (std::size_t f = 0; f < met.size(); ++f) EXPECT_TRUE(limited.gave_up[f] != 0 || met[f] <= budget);
      if (budget == 10) stayed += std::count(limited.gave_up.begin(), limited.gave_up.end(), 0);
    }
  }
  EXPECT_GT(stayed, 100);
}

}  // namespace
}  // namespace accel
