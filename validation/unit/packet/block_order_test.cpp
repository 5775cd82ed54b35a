#include "libaccel/packet/block_order.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <numeric>
#include <vector>

#include "libaccel/core/counter_rng.h"
#include "libaccel/packet/pixel_rows.h"
#include "libaccel/rays/ray_sets.h"
#include "validation/stress/stress_rays.h"

namespace accel {
namespace {

const Aabb kBounds{{-1, -1, -1}, {1, 1, 1}};
constexpr float kCellFraction = 0.05f;

// In all directions, with rays that cannot be traced among them.
std::vector<Ray> rays_of(std::size_t count) {
  CounterRng rng(11, 0);
  const auto coordinate = [&] { return 2 * rng.next_float() - 1; };
  std::vector<Ray> rays(count);
  for (Ray& ray : rays)
    ray.org = {coordinate(), coordinate(), coordinate()}, ray.dir = {coordinate(), coordinate(), coordinate()};
  const auto invalid = validation::invalid_rays();
  for (std::size_t i = 0; i < std::min(invalid.size(), count / 3); ++i) rays[3 * i] = invalid[i];
  return rays;
}

// Every ray is there once, and faces ascend.
void expect_block_of(const std::vector<Ray>& rays, const BlockOrder& order) {
  ASSERT_EQ(order.ids().size(), rays.size());
  ASSERT_EQ(order.faces().size(), rays.size());
  EXPECT_TRUE(std::ranges::is_sorted(order.faces()));
  for (std::size_t i = 0; i < rays.size(); ++i) EXPECT_EQ(order.faces()[i], face_of(rays[order.ids()[i]]));
  std::vector<std::uint32_t> ids(order.ids().begin(), order.ids().end()), all(rays.size());
  std::ranges::sort(ids);
  std::iota(all.begin(), all.end(), 0u);
  EXPECT_EQ(ids, all);
}

// Whether rays of one face come in the order of `is_before`.
template <class Before>
void expect_sorted(const BlockOrder& order, const Before& is_before) {
  for (std::size_t i = 1; i < order.ids().size(); ++i) {
    if (order.faces()[i] == order.faces()[i - 1]) {
      EXPECT_TRUE(is_before(order.ids()[i - 1], order.ids()[i])) << i;
    }
  }
}

TEST(BlockOrder, FacesThenRunsByTheHashValueOfTheirMiddle) {
  const auto hash = RayHash<std::uint64_t, kFineDirectionBits>::make(kBounds, kCellFraction);
  BlockOrder order(kBounds, kCellFraction);
  for (const std::size_t count : {0, 1, 7, 8, 9, 1000, 1003}) {
    const std::vector<Ray> rays = rays_of(count);
    order.begin(rays);
    order.sort(0);
    expect_block_of(rays, order);
    expect_sorted(order, [](std::uint32_t a, std::uint32_t b) { return a < b; });
    for (const std::uint32_t run : {1u, 8u, 13u}) {
      order.sort(run);
      expect_block_of(rays, order);
      const auto value = [&](std::size_t id) { return hash(rays[std::min(id / run * run + run / 2, count - 1)]); };
      std::uint64_t differ = 0;
      for (std::size_t id = 0; id < count; ++id) differ |= value(id) ^ value(0);
      const int unused = std::max(0, static_cast<int>(std::bit_width(differ)) - BlockOrder::kKeyBits);
      // Of runs with equal keys, and within a run, the first one first.
      const auto key = [&](std::uint32_t id) { return std::pair(value(id) >> unused, id); };
      expect_sorted(order, [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
    }
  }
}

std::vector<Ray> picture(std::uint32_t width, std::uint32_t height) {
  const Camera camera = Camera::make({{0, 0, 0}, {0, 0, -1}, {0, 1, 0}, 20, ""}, width, height).value();
  const RaySet set = primary_rays(camera).value();
  return {set.rays.begin(), set.rays.end()};
}

TEST(BlockOrder, TilesWhereRaysComeByRowsOfPixels) {
  constexpr std::uint32_t kWidth = 160, kHeight = 40;
  const std::vector<Ray> rays = picture(kWidth, kHeight);
  BlockOrder order(kBounds, kCellFraction);
  order.begin(rays);
  order.sort(8);
  expect_block_of(rays, order);
  const auto ids = order.ids();
  const auto is_tile = [&](std::size_t first, std::size_t count, std::uint32_t size) {
    for (std::size_t i = first; i < first + count; ++i)
      if (ids[i] % kWidth / size != ids[first] % kWidth / size || ids[i] / kWidth / size != ids[first] / kWidth / size)
        return false;
    return true;
  };
  for (std::size_t first = 0; first < std::size_t{kWidth} * 32; first += 256) EXPECT_TRUE(is_tile(first, 256, 16)) << first;
  for (std::size_t first = 0; first < ids.size(); first += 16) EXPECT_TRUE(is_tile(first, 16, 4)) << first;
}

// Rows that begin anywhere, at the beginning of a block and in memory, and that many faces share.
TEST(BlockOrder, EveryRayOfAPictureIsThereOnce) {
  for (const std::uint32_t width : {131u, 160u, 233u, 402u}) {
    const Camera camera = Camera::make({{0, 0, 0}, {1, 0.3f, -1}, {0, 1, 0}, 12, ""}, width, 50).value();
    const RaySet set = primary_rays(camera).value();
    for (const std::uint32_t skipped : {0u, 1u, 6u, width - 1}) {
      const std::vector<Ray> rays(set.rays.begin() + skipped, set.rays.end() - skipped / 2);
      BlockOrder order(kBounds, kCellFraction);
      order.begin(rays);
      order.sort(8);
      expect_block_of(rays, order);
      EXPECT_EQ(find_rows(rays, 1).length, width);
      EXPECT_NE(order.faces().front(), order.faces().back());
    }
  }
}

TEST(BlockOrder, KeepsWhatIsAskedFor) {
  const std::vector<Ray> rays = rays_of(100);
  BlockOrder order(kBounds, kCellFraction);
  order.begin(rays);
  order.sort(8);
  const std::vector<std::uint32_t> ids(order.ids().begin(), order.ids().end());
  const std::vector<std::uint8_t> faces(order.faces().begin(), order.faces().end());
  const std::pair<std::uint32_t, std::uint32_t> places[] = {{0, 2}, {2, 2}, {50, 51}, {98, 100}};
  order.keep(places);
  EXPECT_THAT(order.ids(), testing::ElementsAre(ids[0], ids[1], ids[50], ids[98], ids[99]));
  EXPECT_THAT(order.faces(), testing::ElementsAre(faces[0], faces[1], faces[50], faces[98], faces[99]));
  order.keep({});
  EXPECT_TRUE(order.ids().empty());
  order.sort(0);
  expect_block_of(rays, order);
}

}  // namespace
}  // namespace accel
