#include "libaccel/core/result.h"

#include <gtest/gtest.h>

#include <memory>

namespace accel {
namespace {

Result<int> half_of(int x) {
  if (x % 2 != 0) return Error{std::to_string(x) + " is odd"};
  return x / 2;
}

TEST(Result, HoldsAValue) {
  const Result<int> result = half_of(4);
  ASSERT_TRUE(result);
  EXPECT_TRUE(result.ok());
  EXPECT_EQ(*result, 2);
  EXPECT_EQ(result.value(), 2);
}

TEST(Result, HoldsAnError) {
  const Result<int> result = half_of(3);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.message(), "3 is odd");
  EXPECT_EQ(result.error().message, "3 is odd");
}

TEST(Result, HoldsValuesThatLookLikeErrors) {
  const Result<std::string> result(std::string("fine"));
  ASSERT_TRUE(result);
  EXPECT_EQ(result->size(), 4u);
}

TEST(Result, MovesOnlyTypes) {
  Result<std::unique_ptr<int>> result(std::make_unique<int>(5));
  ASSERT_TRUE(result);
  const std::unique_ptr<int> taken = std::move(result).value();
  EXPECT_EQ(*taken, 5);
}

TEST(Result, StatusCarriesNothing) {
  const Status good = Done{};
  const Status bad = Error{"no"};
  EXPECT_TRUE(good);
  EXPECT_FALSE(bad);
}

}  // namespace
}  // namespace accel
