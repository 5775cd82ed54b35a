#include "libaccel/packet/ray_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "libaccel/core/counter_rng.h"
#include "libaccel/core/hit.h"

namespace accel {
namespace {

const Aabb kUnitBox{{0, 0, 0}, {1, 1, 1}};

std::vector<Ray> random_rays(std::size_t n) {
  CounterRng rng(1, n);
  const auto next = [&] { return static_cast<float>(rng.next_below(1u << 20)) / 1048576.0f; };
  std::vector<Ray> rays;
  for (std::size_t i = 0; i < n; ++i)
    rays.push_back({.org = {next(), next(), next()}, .dir = {next() - 0.5f, next() - 0.5f, next() - 0.5f}});
  return rays;
}

TEST(RayOrder, IsAPermutationThatGatherAndScatterFollow) {
  std::vector<Ray> rays = random_rays(30000);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  rays[7] = {.org = {nan, nan, nan}, .dir = {nan, 0, nan}};
  rays[8] = {.org = {0, 0, 0}, .dir = {0, 0, 0}};
  for (const RaySort sort : kRaySorts) {
    const RayOrder order = order_rays(rays, kUnitBox, {.sort = sort}).value();
    std::vector<std::uint32_t> sorted(order.ids.begin(), order.ids.end());
    std::sort(sorted.begin(), sorted.end());
    for (std::uint32_t i = 0; i < rays.size(); ++i) ASSERT_EQ(sorted[i], i) << name_of(sort);
    EXPECT_GT(order.chunks, 0u);
    EXPECT_LE(order.chunks, rays.size());

    std::vector<Ray> gathered(rays.size());
    gather_rays(rays, order.ids.span(), gathered);
    std::vector<Hit> from(rays.size()), to(rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) {
      ASSERT_EQ(gathered[i].org == rays[order.ids[i]].org, order.ids[i] != 7) << "NaN is not itself";
      from[i].prim_id = order.ids[i];
    }
    scatter(std::span<const Hit>(from), order.ids.span(), std::span(to));
    for (std::uint32_t i = 0; i < rays.size(); ++i) ASSERT_EQ(to[i].prim_id, i);
  }
}

TEST(RayOrder, IsTheSameForAnyNumberOfThreads) {
  const std::vector<Ray> rays = random_rays(50000);
  for (const RaySort sort : kRaySorts) {
    const RayOrder one = order_rays(rays, kUnitBox, {.sort = sort, .threads = 1}).value();
    for (const int threads : {2, 3}) {
      const RayOrder other = order_rays(rays, kUnitBox, {.sort = sort, .threads = threads}).value();
      EXPECT_TRUE(std::ranges::equal(one.ids, other.ids)) << name_of(sort);
    }
  }
}

// Neighbours in the order start nearer each other than neighbours in the batch, by far.
TEST(RayOrder, MakesNeighboursOfNearRays) {
  const std::vector<Ray> rays = random_rays(20000);
  const auto mean_step = [&](const auto& id_of) {
    double sum = 0;
    for (std::size_t i = 1; i < rays.size(); ++i) {
      const Vec3 step = rays[id_of(i)].org - rays[id_of(i - 1)].org;
      sum += std::sqrt(static_cast<double>(dot(step, step)));
    }
    return sum / static_cast<double>(rays.size());
  };
  const double before = mean_step([](std::size_t i) { return i; });
  for (const RaySort sort : kRaySorts) {
    const RayOrder order = order_rays(rays, kUnitBox, {.sort = sort, .cell_fraction = 0.05f}).value();
    EXPECT_LT(mean_step([&](std::size_t i) { return order.ids[i]; }), 0.3 * before) << name_of(sort);
  }
}

TEST(RayOrder, OfNothing) {
  for (const RaySort sort : kRaySorts) EXPECT_TRUE(order_rays({}, kUnitBox, {.sort = sort}).value().ids.empty());
}

TEST(RayOrder, NamesAreParsed) {
  for (const RaySort sort : kRaySorts) {
    const Result<RaySort> parsed = parse_ray_sort(name_of(sort));
    ASSERT_TRUE(parsed);
    EXPECT_EQ(*parsed, sort);
  }
  const Result<RaySort> unknown = parse_ray_sort("ray-hsah");
  ASSERT_FALSE(unknown);
  EXPECT_NE(unknown.message().find("ray-hash"), std::string::npos);
}

}  // namespace
}  // namespace accel
