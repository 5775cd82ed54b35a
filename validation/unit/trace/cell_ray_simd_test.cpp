#include "libaccel/trace/cell_ray_simd.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "libaccel/trace/traverser.h"
#include "validation/stress/hostile_floats.h"

namespace accel {
namespace {

// Two NaNs are the same answer; zeros of different sign are not.
bool equal_bits(float a, float b) {
  return (std::isnan(a) && std::isnan(b)) || std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b);
}

struct Entered {
  CellRay cells;
  float t_min, t_max;

  template <class Enter>
  static Entered by(const Enter& enter, const Ray& ray, const Aabb& box) {
    Entered result{{}, first_t(ray), ray.t_max};
    result.cells = enter(ray, box, result.t_min, result.t_max);
    return result;
  }
  static Entered simd(const Ray& ray, const Aabb& box) {
    return by([](auto&&... arguments) { return enter_box(arguments...); }, ray, box);
  }
  static Entered scalar(const Ray& ray, const Aabb& box) {
    return by([](auto&&... arguments) { return enter_box_scalar(arguments...); }, ray, box);
  }
};

bool equal_bits(const Entered& a, const Entered& b) {
  bool same = equal_bits(a.t_min, b.t_min) && equal_bits(a.t_max, b.t_max) &&
              a.cells.backwards_axes == b.cells.backwards_axes && equal_bits(a.cells.t_anchor, b.cells.t_anchor) &&
              equal_bits(a.cells.t_unit, b.cells.t_unit);
  for (int axis = 0; axis < 3; ++axis)
    same = same && equal_bits(a.cells.org[axis], b.cells.org[axis]) && equal_bits(a.cells.inv_dir[axis], b.cells.inv_dir[axis]);
  return same;
}

// A box of any size, far away or around the rays.
Aabb random_box(CounterRng& rng, bool hostile) {
  Aabb box;
  while (box.empty() || !in_range(box.lo) || !in_range(box.hi)) {
    const auto point = [&] { return hostile ? validation::hostile_vec3(rng, 12) : validation::random_in_cube(rng, 1); };
    const Vec3 a = point(), b = point();
    box = {min_of(a, b), max_of(a, b)};
  }
  return box;
}

TEST(EnterBox, SimdHasTheBitsOfTheScalarVersion) {
  int entered = 0, moved = 0, scaled = 0;
  for (std::uint64_t i = 0; i < 200'000; ++i) {
    CounterRng rng(1, i);
    const bool hostile = i % 3 == 0;
    const Aabb box = random_box(rng, hostile);
    const auto point = [&] { return hostile ? validation::hostile_vec3(rng, 12) : validation::random_in_cube(rng, 2); };
    Ray ray{.org = point(), .dir = point()};
    if (i % 4 == 1) ray.dir = box.center() - ray.org;
    if (i % 5 == 0) ray.dir[static_cast<int>(rng.next_below(3))] = i % 2 == 0 ? 0.0f : -0.0f;
    if (i % 7 == 0) ray.org[static_cast<int>(rng.next_below(3))] = i % 2 == 0 ? box.lo.x : box.hi.y;  // in a plane, perhaps
    if (i % 11 == 0) ray.dir = ray.dir * 0x1p-66f;
    if (i % 13 == 0) ray.org = ray.org * 100.0f;
    if (i % 4 == 0) ray.t_min = rng.next_float(), ray.t_max = ray.t_min + rng.next_float();
    if (!is_traceable(ray)) continue;

    const Entered scalar = Entered::scalar(ray, box);
    ASSERT_TRUE(equal_bits(scalar, Entered::simd(ray, box))) << i;
    entered += scalar.t_min <= scalar.t_max, moved += scalar.cells.t_anchor != 0, scaled += scalar.cells.t_unit != 1;
  }
  EXPECT_GT(entered, 10'000);
  EXPECT_GT(moved, 1'000);
  EXPECT_GT(scaled, 1'000);
}

// What decides whether distances are the ray's own, at its limits.
TEST(EnterBox, SimdMovesAndScalesTheSameRays) {
  const Aabb box{{0, 0, 0}, {1, 2, 1}};
  const float reach = kPaddingReach * 2;
  for (int axis = 0; axis < 3; ++axis)
    for (const float beyond : {0.0f, 1.0f})
      for (const float sign : {-1.0f, 1.0f}) {
        Ray ray{.org = {0.5f, 0.5f, 0.5f}, .dir = {0.1f, 0.2f, 0.3f}};
        const float limit = sign < 0 ? -reach : box.hi[axis] + reach;
        ray.org[axis] = beyond != 0 ? (sign < 0 ? next_down(limit) : next_up(limit)) : limit;
        ray.dir[axis] = -sign;
        const Entered simd = Entered::simd(ray, box);
        EXPECT_EQ(simd.cells.t_anchor != 0, beyond != 0) << axis << ' ' << sign;
        EXPECT_TRUE(equal_bits(simd, Entered::scalar(ray, box))) << axis << ' ' << sign;
      }
  for (const float size : {CellRay::kTiny, next_down(CellRay::kTiny)}) {
    const Ray ray{.org = {0.5f, 0.5f, 0.5f}, .dir = {-size, 0, size / 2}};
    EXPECT_EQ(Entered::simd(ray, box).cells.t_unit != 1, size < CellRay::kTiny);
    EXPECT_TRUE(equal_bits(Entered::simd(ray, box), Entered::scalar(ray, box)));
  }
}

}  // namespace
}  // namespace accel
