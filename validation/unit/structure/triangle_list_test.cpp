#include "libaccel/structure/triangle_list.h"

#include <gtest/gtest.h>

#include "libaccel/build/triangle_list.h"
#include "validation/unit/build/test_meshes.h"

namespace accel {
namespace {

TriangleList list_of(std::size_t triangles) {
  return std::move(ListBuilder::build(test::soup(triangles, 0.1f), {})->structure);
}

TEST(TriangleList, KeepsMeshOrder) {
  const TriangleList list = list_of(20);
  for (std::uint32_t i = 0; i < 20; ++i) EXPECT_EQ(list.leaves[i * kQuadsPerTriangle].word, i);
}

TEST(ValidateTriangleList, AcceptsListsAndTheEmptyList) {
  EXPECT_TRUE(validate(list_of(20), 20).ok());
  EXPECT_TRUE(validate(list_of(0), 0).ok());
}

TEST(ValidateTriangleList, RejectsDamage) {
  EXPECT_FALSE(validate(list_of(20), 19).ok());
  EXPECT_FALSE(validate(TriangleList{}, 0).ok());
  TriangleList open = list_of(20);
  open.leaves[open.leaves.size() - 1].word = 0;
  EXPECT_FALSE(validate(open, 20).ok());
  TriangleList shorter = list_of(20);
  shorter.leaves.truncate(shorter.leaves.size() - 2);
  EXPECT_FALSE(validate(shorter, 20).ok());
  TriangleList early = list_of(20);
  early.leaves[3 * kQuadsPerTriangle].word = kEndOfLeaf;
  EXPECT_FALSE(validate(early, 20).ok());
}

}  // namespace
}  // namespace accel
