#include "libaccel/core/type_list.h"

#include <gtest/gtest.h>

#include <tuple>
#include <vector>

namespace accel {
namespace {

TEST(TypeList, VisitsInOrder) {
  std::vector<std::size_t> sizes;
  TypeList<char, short, int>::for_each([&](auto tag) { sizes.push_back(sizeof(typename decltype(tag)::type)); });
  EXPECT_EQ(sizes, (std::vector<std::size_t>{1, 2, 4}));
  EXPECT_EQ((TypeList<char, short, int>::size), 3u);
}

TEST(TypeList, AppendsEachTypeOnce) {
  using Once = TypeList<int>::AppendUnique<char>::AppendUnique<int>;
  EXPECT_TRUE((std::is_same_v<Once, TypeList<int, char>>));
  EXPECT_TRUE((std::is_same_v<Once::Apply<std::tuple>, std::tuple<int, char>>));
}

}  // namespace
}  // namespace accel
