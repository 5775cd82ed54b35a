#include "libaccel/trace/box_pair.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "libaccel/trace/traverser.h"
#include "validation/stress/hostile_floats.h"
#include "validation/unit/special_floats.h"

namespace accel {
namespace {

const Aabb kUnit{{0, 0, 0}, {1, 1, 1}};

Bvh2Node node_of(const Aabb& box0, const Aabb& box1) {
  Bvh2Node node{};
  node.set_bounds(0, box0), node.set_bounds(1, box1);
  return node;
}

BoxPairHit intersect(const Aabb& box0, const Aabb& box1, const Ray& ray) {
  return BoxPairTest::prepare(ray, first_t(ray)).intersect(node_of(box0, box1), ray.t_max);
}

bool enters(const Aabb& box, const Ray& ray) {
  const std::uint32_t mask = intersect(box, box, ray).mask;
  EXPECT_TRUE(mask == 0 || mask == 3) << "equal boxes, different answers";
  return mask != 0;
}

// Two NaNs are the same answer; zeros of different sign are not.
bool same_bits(float a, float b) {
  return (std::isnan(a) && std::isnan(b)) || std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b);
}

TEST(BoxPair, SimdHasTheBitsOfTheScalarVersion) {
  int entered = 0;
  for (std::uint64_t i = 0; i < 300'000; ++i) {
    CounterRng rng(1, i);
    const bool hostile = i % 3 == 0;
    const auto point = [&] { return hostile ? validation::hostile_vec3(rng) : validation::random_in_cube(rng, 1); };
    const Aabb boxes[2] = {{point(), point()}, {point(), point()}};
    Ray ray{.org = point(), .dir = point()};
    if (i % 5 == 0) ray.dir[static_cast<int>(rng.next_below(3))] = i % 2 == 0 ? 0.0f : -0.0f;
    if (i % 7 == 0) ray.org[static_cast<int>(rng.next_below(3))] = boxes[0].lo.x;
    const float t_max = i % 2 == 0 ? kInfinity : rng.next_float();

    Bvh2Node node = node_of(boxes[0], boxes[1]);
    if (i % 3 == 1)  // ordered planes, so that boxes are entered
      for (int c = 0; c < 2; ++c) node.set_bounds(c, {min_of(boxes[c].lo, boxes[c].hi), max_of(boxes[c].lo, boxes[c].hi)});
    const float t_min = rng.next_float();
    const BoxPairHit scalar = ScalarBoxPairTest::prepare(ray, t_min).intersect(node, t_max);
    const BoxPairHit simd = BoxPairTest::prepare(ray, t_min).intersect(node, t_max);
    ASSERT_EQ(scalar.mask, simd.mask) << i;
    ASSERT_TRUE(same_bits(scalar.t_near0, simd.t_near0)) << i << ' ' << scalar.t_near0 << ' ' << simd.t_near0;
    ASSERT_TRUE(same_bits(scalar.t_near1, simd.t_near1)) << i << ' ' << scalar.t_near1 << ' ' << simd.t_near1;
    entered += scalar.mask != 0;
  }
  EXPECT_GT(entered, 10'000);
}

// The smallest box of floats that surely contains the point org + t dir.
Aabb box_around(const Ray& ray, long double t) {
  Aabb box;
  for (int a = 0; a < 3; ++a) {
    const long double step = t * ray.dir[a], p = ray.org[a] + step;
    const long double error = (std::fabs(step) + std::fabs(static_cast<long double>(ray.org[a]))) * 0x1p-52L;
    box.lo[a] = round_down(static_cast<double>(p - error)), box.hi[a] = round_up(static_cast<double>(p + error));
  }
  return box;
}

// Boxes as thin as a float, hit in one point: the test must never lose them.
TEST(BoxPair, NeverLosesABoxThatTheRayMeets) {
  for (std::uint64_t i = 0; i < 200'000; ++i) {
    CounterRng rng(2, i);
    Ray ray;
    const int spread = i % 2 == 0 ? 2 : 20;
    for (int a = 0; a < 3; ++a) {
      ray.org[a] = validation::random_over_exponents(rng, -spread, spread);
      ray.dir[a] = validation::random_over_exponents(rng, -spread, spread);
    }
    if (i % 3 == 0) ray.dir[static_cast<int>(rng.next_below(3))] = i % 2 == 0 ? 0.0f : -0.0f;
    const float t = std::fabs(validation::random_over_exponents(rng, -10, 10));
    const Aabb box = box_around(ray, t);
    EXPECT_TRUE(enters(box, ray)) << i;

    // Not even when the interval begins or ends right there.
    ray.t_max = t;
    EXPECT_TRUE(enters(box, ray)) << i;
    ray.t_min = t, ray.t_max = kInfinity;
    EXPECT_TRUE(enters(box, ray)) << i;
  }
}

TEST(BoxPair, MissesWhatItShould) {
  EXPECT_FALSE(enters(kUnit, {.org = {2, 0.5f, 0.5f}, .dir = {1, 0, 0}}));
  EXPECT_FALSE(enters(kUnit, {.org = {0.5f, 0.5f, -1}, .dir = {1, 0, 0}}));
  EXPECT_FALSE(enters(kUnit, {.org = {-1, 0.5f, 0.5f}, .dir = {1, 0, 0}, .t_max = 0.99f}));
  EXPECT_FALSE(enters(kUnit, {.org = {-1, 0.5f, 0.5f}, .t_min = 2.01f, .dir = {1, 0, 0}}));
  EXPECT_FALSE(enters(Aabb{}, {.org = {-1, 0.5f, 0.5f}, .dir = {1, 0, 0}}));
}

TEST(BoxPair, ParallelRaysInAFaceAreInside) {
  for (const float zero : {0.0f, -0.0f}) {
    EXPECT_TRUE(enters(kUnit, {.org = {-1, 0, 0.5f}, .dir = {1, zero, zero}}));
    EXPECT_TRUE(enters(kUnit, {.org = {-1, 1, 0.5f}, .dir = {1, zero, zero}}));
    EXPECT_TRUE(enters(kUnit, {.org = {-1, 1, 1}, .dir = {1, zero, zero}}));
    EXPECT_FALSE(enters(kUnit, {.org = {-1, next_up(1.0f), 0.5f}, .dir = {1, zero, zero}}));
    EXPECT_FALSE(enters(kUnit, {.org = {-1, next_down(0.0f), 0.5f}, .dir = {1, zero, zero}}));
  }
}

// Components whose reciprocal overflows stand for a slope, not for parallel.
TEST(BoxPair, DenormalDirectionsAreConservative) {
  const float tiny = std::numeric_limits<float>::denorm_min();
  for (const float d : {tiny, -tiny, 7 * tiny}) {
    EXPECT_TRUE(enters(kUnit, {.org = {-1, 0, 0.5f}, .dir = {1, d, 0}}));
    EXPECT_TRUE(enters(kUnit, {.org = {-1, 1, 0.5f}, .dir = {1, d, 0}}));
    EXPECT_TRUE(enters(kUnit, {.org = {0.5f, 0.5f, 0.5f}, .dir = {d, d, d}}));
  }
}

TEST(BoxPair, IntervalIsClosed) {
  const Ray ray{.org = {-1, 0.5f, 0.5f}, .dir = {1, 0, 0}};
  const auto within = [&](float t_min, float t_max) {
    return enters(kUnit, {.org = ray.org, .t_min = t_min, .dir = ray.dir, .t_max = t_max});
  };
  EXPECT_TRUE(within(0, 1));
  EXPECT_TRUE(within(2, 3));
  EXPECT_TRUE(within(1.5f, 1.5f));
}

TEST(BoxPair, TellsWhereEachChildIsEntered) {
  const Aabb near_box{{0, 0, 0}, {1, 1, 1}}, far_box{{2, 0, 0}, {3, 1, 1}};
  const BoxPairHit both = intersect(far_box, near_box, {.org = {-1, 0.5f, 0.5f}, .dir = {1, 0, 0}});
  EXPECT_EQ(both.mask, 3u);
  EXPECT_EQ(both.t_near0, 3.0f);
  EXPECT_EQ(both.t_near1, 1.0f);

  // Each child has its own bit; a ray that starts inside enters at the interval's start.
  const BoxPairHit inside = intersect(far_box, near_box, {.org = {0.5f, 0.5f, 0.5f}, .dir = {-1, 0, 0}});
  EXPECT_EQ(inside.mask, 2u);
  EXPECT_EQ(inside.t_near1, 0.0f);
  EXPECT_EQ(intersect(far_box, near_box, {.org = {1.5f, 0.5f, 0.5f}, .dir = {1, 0, 0}}).mask, 1u);
}

}  // namespace
}  // namespace accel
