#include "libaccel/build/wide_forests.h"

#include <gtest/gtest.h>

#include <cstring>

#include "libaccel/core/counter_rng.h"

namespace accel {
namespace {

TEST(WideForests, SplitsHaveTheBitsOfTheTwin) {
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    CounterRng rng(1, seed);
    alignas(16) float left[8], right[8], ours[8], twin[8];
    for (int i = 0; i < 8; ++i) left[i] = rng.next_float(0, 1), right[i] = seed % 3 == 0 ? left[i] : rng.next_float(0, 1e-3f);
    choose_split(left, right, ours), choose_split_scalar(left, right, twin);
    EXPECT_EQ(std::memcmp(ours, twin, sizeof(ours)), 0) << seed;
  }
}

// Of six leaves in a balanced tree: what it costs to have each as a child, and what a node of its own would.
TEST(WideForests, AreAsCheapAsTheyCanBe) {
  const WideForests leaf(1.0f);
  WideForests two, three, six;
  two.choose(leaf, leaf, 0.5f, 1e9f), three.choose(two, leaf, 0.5f, 1e9f), six.choose(three, three, 0.5f, 1e9f);
  EXPECT_NEAR(two.cost(1), 2.5f, 1e-5f);
  EXPECT_NEAR(two.cost(2), 2.0f, 1e-5f);
  EXPECT_NEAR(three.cost(1), 3.5f, 1e-5f);
  EXPECT_NEAR(three.cost(2), 3.5f, 1e-5f);  // a node of all, or one of two
  EXPECT_NEAR(three.cost(3), 3.0f, 1e-5f);
  EXPECT_NEAR(six.cost(1), 6.5f, 1e-5f);
  EXPECT_NEAR(six.cost(6), 6.0f, 1e-5f);
  int roots = 8;
  EXPECT_GE(six.left(roots), 3);
  EXPECT_EQ(roots, 8);
  EXPECT_FALSE(six.is_leaf());
}

TEST(WideForests, ALeafThatIsCheaperIsALeaf) {
  const WideForests leaf(1.0f);
  WideForests two;
  two.choose(leaf, leaf, 1.0f, 1.5f);
  EXPECT_TRUE(two.is_leaf());
  EXPECT_NEAR(two.cost(1), 1.5f, 1e-5f);
  int roots = 2;
  EXPECT_EQ(two.left(roots), 0);
  EXPECT_EQ(roots, 1);
}

}  // namespace
}  // namespace accel
