#include "libaccel/registry/multi_hit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "validation/stress/stress_scenes.h"

namespace accel {
namespace {

using testing::HasSubstr;

// Sheets over one another at z = 0, 1, ..., numbered from the bottom.
AnyAccel sheets(std::uint32_t count) {
  std::vector<Triangle> triangles;
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto z = static_cast<float>(i);
    triangles.push_back({{0, 0, z}, {1, 0, z}, {0, 1, z}});
  }
  Result<AnyAccel> accel = AnyAccel::build(validation::mesh_of(triangles), "sbvh/stack");
  EXPECT_TRUE(accel) << accel.message();
  return *std::move(accel);
}
const Ray kUpwards{.org = {0.25f, 0.25f, -1}, .dir = {0, 0, 1}};

// Numbers of hits on both sides of all numbers that are fetched at a time.
TEST(ForEachHit, VisitsEveryHitInOrder) {
  for (const std::uint32_t count : {0u, 1u, 3u, 4u, 5u, 11u, 12u, 13u, 27u, 28u, 29u, 60u, 61u, 124u, 125u, 188u, 300u}) {
    const AnyAccel accel = sheets(count);
    std::uint32_t next = 0;
    const std::size_t visited = for_each_hit(accel, kUpwards, [&](const Hit& hit) {
      EXPECT_EQ(hit.prim_id, next);
      EXPECT_EQ(hit.t, static_cast<float>(next + 1));
      ++next;
      return true;
    });
    EXPECT_EQ(visited, count);
    EXPECT_EQ(next, count);
  }
}

TEST(ForEachHit, StopsWhereTheVisitorSaysSo) {
  const AnyAccel accel = sheets(50);
  for (const std::size_t wanted : {1u, 4u, 5u, 49u, 50u}) {
    std::size_t visits = 0;
    EXPECT_EQ(for_each_hit(accel, kUpwards, [&](const Hit&) { return ++visits < wanted; }), wanted);
    EXPECT_EQ(visits, wanted);
  }
}

TEST(KNearest, SingleRaysAsBatches) {
  const AnyAccel accel = sheets(6);
  std::vector<Hit> hits(4);
  EXPECT_EQ(accel.k_nearest(kUpwards, hits), 4u);
  EXPECT_EQ(hits[3].prim_id, 3u);
  const Hit last = hits[3];
  EXPECT_EQ(accel.next_hits(kUpwards, last, hits), 2u);
  EXPECT_EQ(hits[1].prim_id, 5u);
  EXPECT_FALSE(hits[2].valid());
  EXPECT_EQ(accel.next_hits(kUpwards, Hit{}, hits), 0u);
  EXPECT_EQ(accel.k_nearest(kUpwards, {}), 0u);
}

TEST(KNearest, ChecksSpansAndTestNames) {
  const AnyAccel accel = sheets(3);
  const std::vector<Ray> rays(2, kUpwards);
  std::vector<Hit> hits(6), after(2);
  std::vector<std::uint32_t> counts(2);
  EXPECT_TRUE(accel.k_nearest(rays, 3, hits, counts));
  EXPECT_TRUE(accel.next_hits(rays, after, 3, hits, counts));
  EXPECT_TRUE(accel.k_nearest(rays, 0, {}, counts));
  EXPECT_TRUE(accel.k_nearest({}, 3, {}, {}));
  const Status room = accel.k_nearest(rays, 4, hits, counts);
  ASSERT_FALSE(room);
  EXPECT_THAT(room.message(), HasSubstr("2 rays with 4 hits each, but room for 6"));
  EXPECT_FALSE(accel.k_nearest(rays, 3, hits, std::span(counts).first(1)));
  EXPECT_FALSE(accel.k_nearest(rays, 0, hits, counts));
  EXPECT_FALSE(accel.k_nearest(rays, std::size_t{1} << 63, hits, counts));
  EXPECT_FALSE(accel.next_hits(rays, std::span(after).first(1), 3, hits, counts));
  const Status test = accel.k_nearest(rays, 3, hits, counts, {.test = "watertite"});
  ASSERT_FALSE(test);
  EXPECT_THAT(test.message(), HasSubstr("did you mean 'watertight'"));
}

}  // namespace
}  // namespace accel
