#include "libaccel/build/wide_node.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "libaccel/core/counter_rng.h"

namespace accel {
namespace {

Box4 random_box(std::uint64_t seed, std::uint64_t child) {
  CounterRng rng(seed, child);
  const auto coordinate = [&] { return seed % 4 == 0 ? std::floor(rng.next_float(-2, 3)) : rng.next_float(-1, 1); };  // ties
  Aabb box;
  for (int i = 0; i < 2; ++i) {
    const float x = coordinate(), y = coordinate(), z = coordinate();
    box.extend(Vec3{x, y, z});
  }
  return Box4::of(box);
}

float distance(const Bvh8Node& node, std::uint32_t c, std::uint32_t octant) {
  const Vec3 centre = node.bounds(c).center();
  float sum = 0;
  for (int a = 0; a < 3; ++a) sum += (octant >> a & 1u) != 0 ? centre[a] : -centre[a];
  return sum;
}

TEST(WideNode, ChildrenComeByDistanceForEveryOctant) {
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    const auto count = static_cast<std::uint32_t>(1 + seed % kBvh8Arity);
    WideChild children[kBvh8Arity];
    for (std::uint32_t c = 0; c < count; ++c) children[c] = {c + 10, random_box(seed, c)};
    Bvh8Node node;
    make_wide_node(children, count, node);
    for (std::uint32_t c = 0; c < kBvh8Arity; ++c) {
      EXPECT_EQ(node.child[c], c < count ? c + 10 : kNoNode);
      EXPECT_EQ(node.is_absent(c), c >= count);
      if (c >= count) continue;
      EXPECT_TRUE(node.bounds(c).lo == children[c].box.aabb().lo && node.bounds(c).hi == children[c].box.aabb().hi);
    }
    for (std::uint32_t octant = 0; octant < 8; ++octant) {
      std::set<std::uint32_t> seen;
      for (std::uint32_t i = 0; i < kBvh8Arity; ++i) {
        const std::uint32_t c = node.ordered(i, octant);
        seen.insert(c);
        EXPECT_EQ(c >= count, i >= count);  // absent ones last
        if (i == 0 || i >= count) continue;
        EXPECT_LE(distance(node, node.ordered(i - 1, octant), octant), distance(node, c, octant));
      }
      EXPECT_EQ(seen.size(), kBvh8Arity);
    }
    for (const std::uint32_t word : node.order) EXPECT_EQ(word >> 24, 0u);
  }
}

}  // namespace
}  // namespace accel
