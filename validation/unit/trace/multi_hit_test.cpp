#include "libaccel/trace/multi_hit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "libaccel/core/counter_rng.h"
#include "libaccel/geometry/moeller_trumbore.h"
#include "libaccel/geometry/watertight.h"
#include "validation/unit/special_floats.h"

namespace accel {
namespace {

Hit hit_at(float t, std::uint32_t prim_id) { return {.t = t, .prim_id = prim_id}; }

TEST(HitPlace, OrdersByDistanceThenNumber) {
  EXPECT_TRUE(is_before({1, 9}, {2, 0}));
  EXPECT_TRUE(is_before({1, 3}, {1, 4}));
  EXPECT_FALSE(is_before({1, 4}, {1, 4}));
  EXPECT_FALSE(is_before({2, 0}, {1, 9}));
  EXPECT_FALSE(is_before({kNaN, 0}, {1, 9}));
  EXPECT_FALSE(is_before({1, 9}, {kNaN, 0}));
  EXPECT_TRUE(is_before(kBeforeAllHits, {0, 0}));
  EXPECT_TRUE(is_before(kBeforeAllHits, {-0.0f, 0}));
}

class HitBufferTest : public testing::Test {
 protected:
  HitBuffer buffer(std::uint32_t capacity, Ray ray = {.dir = {0, 0, 1}}, HitPlace after = kBeforeAllHits) {
    hits_.assign(capacity, Hit{});
    return HitBuffer::prepare(ray, after, hits_.data(), capacity);
  }
  std::vector<Hit> hits_;
};

TEST_F(HitBufferTest, KeepsTheNearestInOrderAndEachOnce) {
  for (std::uint32_t capacity = 1; capacity <= 12; ++capacity) {
    HitBuffer b = buffer(capacity);
    std::vector<HitPlace> all;
    CounterRng rng(3, capacity);
    for (int i = 0; i < 40; ++i) {
      const HitPlace place{static_cast<float>(rng.next_below(6)), static_cast<std::uint32_t>(rng.next_below(5))};
      b.take(hit_at(place.t, place.prim_id));
      all.push_back(place);
    }
    std::sort(all.begin(), all.end(), is_before);
    const auto is_same = [](HitPlace x, HitPlace y) { return !is_before(x, y); };  // of sorted ones
    all.erase(std::unique(all.begin(), all.end(), is_same), all.end());
    ASSERT_EQ(b.count, std::min<std::size_t>(capacity, all.size()));
    for (std::uint32_t i = 0; i < b.count; ++i) {
      EXPECT_EQ(b.hits[i].t, all[i].t);
      EXPECT_EQ(b.hits[i].prim_id, all[i].prim_id);
    }
  }
}

TEST_F(HitBufferTest, SaysWhatGotIn) {
  HitBuffer b = buffer(2);
  EXPECT_TRUE(b.take(hit_at(5, 1)));
  EXPECT_FALSE(b.take(hit_at(5, 1))) << "it is there";
  EXPECT_FALSE(b.is_full());
  EXPECT_TRUE(b.take(hit_at(7, 1)));
  EXPECT_TRUE(b.is_full());
  EXPECT_FALSE(b.take(hit_at(7, 2))) << "too far";
  EXPECT_TRUE(b.take(hit_at(7, 0))) << "the lower number comes first";
  EXPECT_FALSE(b.take(hit_at(7, 1))) << "it has been pushed out";
  EXPECT_EQ(b.count, 2u);
}

TEST_F(HitBufferTest, HoldsToTheInterval) {
  HitBuffer b = buffer(8, {.t_min = 1, .dir = {0, 0, 1}, .t_max = 2});
  EXPECT_FALSE(b.take(hit_at(0.999f, 0)));
  EXPECT_TRUE(b.take(hit_at(1, 1)));
  EXPECT_TRUE(b.take(hit_at(2, 2)));
  EXPECT_FALSE(b.take(hit_at(2.001f, 3)));
  EXPECT_FALSE(b.take(hit_at(kNaN, 4)));
  HitBuffer whole = buffer(8, {.t_min = -5, .dir = {0, 0, 1}});
  EXPECT_FALSE(whole.take(hit_at(-1, 0)));
  EXPECT_TRUE(whole.take(hit_at(0, 0)));
  EXPECT_FALSE(whole.take(hit_at(kInfinity, 0)));
}

TEST_F(HitBufferTest, TakesNothingUpToTheHitItGoesOnBehind) {
  HitBuffer b = buffer(8, {.dir = {0, 0, 1}}, {3, 5});
  EXPECT_FALSE(b.take(hit_at(2, 9)));
  EXPECT_FALSE(b.take(hit_at(3, 4)));
  EXPECT_FALSE(b.take(hit_at(3, 5)));
  EXPECT_TRUE(b.take(hit_at(3, 6)));
  EXPECT_TRUE(b.take(hit_at(4, 0)));
}

const PackedTriangle kTriangle = pack({{0, 0, 2}, {1, 0, 2}, {0, 1, 2}}, 7);
const Ray kRayAlongX{.org = {0.25f, 0.25f, 0}, .dir = {0, 0, 1}};

template <class Test>
class MultiHitTests : public testing::Test {};
using Tests = testing::Types<Watertight, MoellerTrumbore>;
TYPED_TEST_SUITE(MultiHitTests, Tests);

TYPED_TEST(MultiHitTests, CollectReportsOnlyTheEndOfAFullBuffer) {
  Hit hits[2];
  HitBuffer buffer = HitBuffer::prepare(kRayAlongX, kBeforeAllHits, hits, 2);
  auto data = Collect<TypeParam>::prepare(kRayAlongX);
  data.buffer = &buffer;
  Hit hit;
  EXPECT_FALSE((Collect<TypeParam>::intersect(kTriangle, kRayAlongX, data, hit)));
  EXPECT_FALSE((Collect<TypeParam>::intersect(kTriangle, kRayAlongX, data, hit))) << "a second leaf has it too";
  EXPECT_EQ(buffer.count, 1u);
  EXPECT_EQ(hits[0].t, 2.0f);
  EXPECT_EQ(hits[0].prim_id, 7u);

  buffer.take(hit_at(9, 1));
  const PackedTriangle nearer = pack({{0, 0, 1}, {1, 0, 1}, {0, 1, 1}}, 3);
  auto inside = Collect<TypeParam>::prepare(kRayAlongX);
  inside.enter_instance(data, 100);
  EXPECT_TRUE((Collect<TypeParam>::intersect(nearer, kRayAlongX, inside, hit)));
  EXPECT_EQ(hit.t, 2.0f) << "the farthest that is in";
  EXPECT_EQ(hits[0].prim_id, 103u);
}

TYPED_TEST(MultiHitTests, AfterFindsOnlyWhatIsBehind) {
  auto data = After<TypeParam>::prepare(kRayAlongX);
  Hit hit;
  EXPECT_TRUE((After<TypeParam>::intersect(kTriangle, kRayAlongX, data, hit)));
  data.after = {2, 6};
  EXPECT_TRUE((After<TypeParam>::intersect(kTriangle, kRayAlongX, data, hit)));
  data.after = {2, 7};
  EXPECT_FALSE((After<TypeParam>::intersect(kTriangle, kRayAlongX, data, hit)));
  auto inside = After<TypeParam>::prepare(kRayAlongX);
  inside.enter_instance(data, 1);
  EXPECT_TRUE((After<TypeParam>::intersect(kTriangle, kRayAlongX, inside, hit))) << "numbers are those of the scene";
}

TEST(Behind, StartsAtTheHitAndNotInFrontOfTheRay) {
  EXPECT_EQ(behind({.t_min = 1}, {3, 0}).t_min, 3.0f);
  EXPECT_EQ(behind({.t_min = 5}, {3, 0}).t_min, 5.0f);
  EXPECT_EQ(first_t(behind({.t_min = -5}, kBeforeAllHits)), 0.0f);
  EXPECT_FALSE(is_traceable(behind({.t_min = kNaN, .dir = {0, 0, 1}}, {3, 0})));
  EXPECT_FALSE(is_traceable(behind({.t_min = 2, .dir = {0, 0, 1}, .t_max = 1}, {1.5f, 0})));
}

}  // namespace
}  // namespace accel
