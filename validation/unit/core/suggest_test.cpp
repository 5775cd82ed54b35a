#include "libaccel/core/suggest.h"

#include <gtest/gtest.h>

#include <array>

namespace accel {
namespace {

constexpr std::array<std::string_view, 4> kNames{"stadium", "spheres", "soup", "soft-shadow"};

TEST(EditDistance, CountsEdits) {
  EXPECT_EQ(edit_distance("", ""), 0);
  EXPECT_EQ(edit_distance("", "abc"), 3);
  EXPECT_EQ(edit_distance("abc", ""), 3);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3);
  EXPECT_EQ(edit_distance("stadium", "stdaium"), 1) << "two neighbours swapped are one edit";
  EXPECT_EQ(edit_distance("Soup", "sOUP"), 0) << "case does not count";
}

TEST(EditDistance, IsSymmetric) {
  for (const auto a : kNames)
    for (const auto b : kNames) EXPECT_EQ(edit_distance(a, b), edit_distance(b, a)) << a << ' ' << b;
}

TEST(ClosestMatch, FindsSlips) {
  EXPECT_EQ(closest_match("stadum", kNames), "stadium");
  EXPECT_EQ(closest_match("sphere", kNames), "spheres");
  EXPECT_EQ(closest_match("suop", kNames), "soup");
  EXPECT_EQ(closest_match("soft_shadow", kNames), "soft-shadow");
}

TEST(ClosestMatch, AcceptsBeginnings) { EXPECT_EQ(closest_match("sta", kNames), "stadium"); }

TEST(ClosestMatch, RefusesWhatIsFar) {
  EXPECT_FALSE(closest_match("kitchen", kNames));
  EXPECT_FALSE(closest_match("", kNames));
  EXPECT_FALSE(closest_match("x", {}));
}

TEST(UnknownName, SuggestsOrLists) {
  EXPECT_EQ(unknown_name("scene", "stadum", kNames).message, "unknown scene 'stadum'; did you mean 'stadium'?");
  EXPECT_EQ(unknown_name("scene", "kitchen", kNames).message,
            "unknown scene 'kitchen'; known are stadium, spheres, soup, soft-shadow");
}

}  // namespace
}  // namespace accel
