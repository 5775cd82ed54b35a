#include "libaccel/packet/csd_sort.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <numeric>
#include <vector>

#include "libaccel/core/counter_rng.h"
#include "libaccel/packet/cpu_primitives.h"

namespace accel {
namespace {

// [GL10] Fig. 4: the chunks of the example have sizes 3, 4, 2, 5, 3 and 3.
TEST(CsdSort, TheExampleOfThePaper) {
  std::vector<std::uint32_t> hashes;
  const std::uint32_t sizes[] = {3, 4, 2, 5, 3, 3}, values[] = {2, 0, 1, 2, 0, 3};
  for (int c = 0; c < 6; ++c) hashes.insert(hashes.end(), sizes[c], values[c]);
  const auto order = csd_sort<CpuPrimitives>(hashes.data(), hashes.size());
  EXPECT_EQ(order.chunks, 6u);
  const std::vector<std::uint32_t> ids(order.ids.begin(), order.ids.end());
  EXPECT_EQ(ids, (std::vector<std::uint32_t>{3, 4, 5, 6, 14, 15, 16, 7, 8, 0, 1, 2, 9, 10, 11, 12, 13, 17, 18, 19}));
}

TEST(CsdSort, IsAStableSort) {
  for (const std::size_t n : {0ul, 1ul, 2ul, 1000ul, 70000ul})
    for (const std::uint32_t run : {1u, 3u, 40u, 100000u}) {
      std::vector<std::uint64_t> hashes;
      CounterRng rng(1, n + run);
      while (hashes.size() < n) hashes.insert(hashes.end(), 1 + rng.next_below(run), rng.next_u64() & 0xff000000000000ffull);
      hashes.resize(n);
      std::vector<std::uint32_t> expected(n);
      std::iota(expected.begin(), expected.end(), 0u);
      std::stable_sort(expected.begin(), expected.end(),
                       [&](std::uint32_t a, std::uint32_t b) { return hashes[a] < hashes[b]; });
      const auto order = csd_sort<CpuPrimitives>(hashes.data(), n);
      EXPECT_TRUE(std::equal(order.ids.begin(), order.ids.end(), expected.begin(), expected.end())) << n << ", runs of " << run;
      const std::size_t chunks = n == 0 ? 0
                                        : 1 + std::inner_product(hashes.begin() + 1, hashes.end(), hashes.begin(), 0ul,
                                                                 std::plus(), std::not_equal_to());
      EXPECT_EQ(order.chunks, chunks);
      const auto plain = plain_sort<CpuPrimitives>(hashes.data(), n);
      EXPECT_TRUE(std::equal(plain.begin(), plain.end(), expected.begin(), expected.end()));
      EXPECT_TRUE(std::is_sorted(hashes.begin(), hashes.end()));
    }
}

}  // namespace
}  // namespace accel
