// Hash values in SIMD lanes against those of one ray, on every target that the machine has.
#include "libaccel/packet/ray_hash_simd.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "libaccel/core/counter_rng.h"
#include "validation/stress/stress_rays.h"
#include "validation/unit/packet/packets_on_targets.h"
#include "validation/unit/special_floats.h"

namespace accel {
namespace {

// In all directions, in the box of the hash and around it; and what no ray should be.
std::vector<Ray> rays_of_all_kinds() {
  CounterRng rng(5, 0);
  const auto coordinate = [&] { return 3 * rng.next_float() - 1.5f; };
  std::vector<Ray> rays = validation::invalid_rays();
  const float all[] = {0.0f, -0.0f, 1, -1, 1e-40f, 1e38f, -kInfinity, std::nanf("")};
  for (const float x : all)
    for (const float y : all)
      for (const float z : all) {
        rays.push_back({.org = {1, 2, 3}, .dir = {x, y, z}});
        rays.push_back({.org = {x, y, z}, .dir = {1, -2, 1}});
      }
  while (rays.size() < 2000)
    rays.push_back({.org = {coordinate(), coordinate(), coordinate()}, .dir = {coordinate(), coordinate(), coordinate()}});
  return rays;
}

TEST(RayHashSimd, ValuesAreThoseOfTheScalarTwin) {
  const std::vector<Ray> rays = rays_of_all_kinds();
  for (const Aabb& bounds : {Aabb{{-1, -1, -1}, {1, 1, 1}}, Aabb{{0, 0, 0}, {0, 0, 0}}, Aabb{}}) {
    const auto hash = FineRayHash::make(bounds, 0.004f);
    test::on_every_target([&] {
      // In an order of their own, in runs, and counts that are no whole number of vectors.
      for (const std::size_t step : {1u, 7u})
        for (const std::size_t count : {std::size_t{0}, std::size_t{1}, std::size_t{21}, rays.size()}) {
          std::vector<std::uint32_t> ids(count);
          for (std::size_t i = 0; i < count; ++i) ids[i] = static_cast<std::uint32_t>(i * step % rays.size());
          std::vector<std::uint64_t> values(count + 1, 17);
          hash_rays_simd(hash, rays.data(), ids.data(), count, values.data());
          for (std::size_t i = 0; i < count; ++i)
            ASSERT_EQ(values[i], hash(rays[ids[i]])) << packet_simd_target() << ", ray " << ids[i];
          EXPECT_EQ(values[count], 17u) << "nothing is written beyond";
        }
    });
  }
}

}  // namespace
}  // namespace accel
