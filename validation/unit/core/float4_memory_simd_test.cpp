// The functions for SSE2 have the bits of their portable twins.
#include "libaccel/core/float4_memory_simd.h"

#include <gtest/gtest.h>

#include "libaccel/core/counter_rng.h"

namespace accel {
namespace {

Vec3 random_corner(CounterRng& rng) {
  const float x = rng.next_float(-1, 1), y = rng.next_float(-1, 1), z = rng.next_float(-1, 1);
  return {x, y, z};
}

template <class A, class B>
bool same_bytes(const A& a, const B& b) {
  static_assert(sizeof(A) == sizeof(B));
  return std::memcmp(&a, &b, sizeof(a)) == 0;
}

TEST(Float4Memory, PointsHaveZeroBehind) {
  const Vec3 points[] = {{1, 2, 3}, {4, 5, 6}};
  for (const Vec3& p : points) EXPECT_TRUE(same_bytes(load_point(p), Float4::of(p)));
}

TEST(Float4Memory, AWordIsStoredAsItIs) {
  for (const std::uint32_t word : {0u, 1u, 0x7f800001u, 0xffffffffu}) {
    alignas(16) std::uint32_t ours[4], twin[4];
    store_with_word(ours, Float4::splat(0.7f), word), store_with_word(twin, Float4Scalar::splat(0.7f), word);
    EXPECT_TRUE(same_bytes(ours, twin));
    EXPECT_EQ(ours[3], word);
  }
}

TEST(Float4Memory, TransposedAndMeasuredAsByTheTwin) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    CounterRng rng(1, seed);
    Float4 lo[4], hi[4], out[3];
    Float4Scalar twin_lo[4], twin_hi[4], twin_out[3];
    Box4 box[4];
    const float scale = rng.next_float(0, 2);
    for (int i = 0; i < 4; ++i) {
      const Vec3 p = random_corner(rng), q = random_corner(rng), low = min_of(p, q), high = max_of(p, q);
      lo[i] = Float4::of(low), hi[i] = Float4::of(high);
      twin_lo[i] = Float4Scalar::of(low), twin_hi[i] = Float4Scalar::of(high);
      box[i] = {lo[i], hi[i]};
    }
    transpose(lo, out), transpose(twin_lo, twin_out);
    EXPECT_TRUE(same_bytes(out, twin_out));
    float area[4], twin_area[4];
    half_areas(lo, hi, Float4::splat(scale), area), half_areas(twin_lo, twin_hi, Float4Scalar::splat(scale), twin_area);
    EXPECT_TRUE(same_bytes(area, twin_area));
    for (int i = 0; i < 4; ++i) EXPECT_EQ(area[i], box[i].half_area(Float4::splat(scale)));
  }
}

}  // namespace
}  // namespace accel
