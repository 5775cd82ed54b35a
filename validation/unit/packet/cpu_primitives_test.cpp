// Each primitive against its serial twin, at sizes around those where work is cut into chunks.
#include "libaccel/packet/cpu_primitives.h"

#include <gtest/gtest.h>

#include <tbb/task_arena.h>

#include <algorithm>
#include <numeric>
#include <vector>

#include "libaccel/core/counter_rng.h"
#include "libaccel/core/threads.h"
#include "libaccel/packet/serial_primitives.h"

namespace accel {
namespace {

const std::size_t kSizes[] = {0, 1, 2, 255, kChunk - 1, kChunk, kChunk + 1, 2 * kChunk, 5 * kChunk + 17, 100000};

std::vector<std::uint32_t> random_values(std::size_t n, std::uint32_t below, std::uint64_t seed) {
  CounterRng rng(seed, n);
  std::vector<std::uint32_t> values(n);
  for (std::uint32_t& value : values) value = rng.next_below(below);
  return values;
}

// Ones at random, on average one in `every`.
std::vector<std::uint8_t> random_flags(std::size_t n, std::uint32_t every, std::uint64_t seed) {
  std::vector<std::uint8_t> flags;
  for (const std::uint32_t value : random_values(n, every, seed)) flags.push_back(value == 0 ? 3 : 0);
  return flags;
}

template <class Body>
void with_threads(const Body& body) {
  for (const int threads : {1, 2, 3}) tbb::task_arena(arena_size(threads)).execute(body);
}

TEST(CpuPrimitives, ForEachVisitsEveryIndexOnce) {
  with_threads([] {
    for (const std::size_t n : kSizes) {
      std::vector<int> visits(n);
      CpuPrimitives::for_each(n, [&](std::size_t i) { ++visits[i]; });
      EXPECT_EQ(std::count(visits.begin(), visits.end(), 1), static_cast<std::ptrdiff_t>(n));
    }
  });
}

TEST(CpuPrimitives, ExclusiveScan) {
  with_threads([] {
    for (const std::size_t n : kSizes) {
      const auto in = random_values(n, 1000, 1);
      std::vector<std::uint32_t> expected(n), out(n), in_place = in;
      std::exclusive_scan(in.begin(), in.end(), expected.begin(), 0u);
      const std::uint32_t total = CpuPrimitives::exclusive_scan(in.data(), n, out.data());
      EXPECT_EQ(total, std::accumulate(in.begin(), in.end(), 0u));
      EXPECT_EQ(out, expected) << n;
      CpuPrimitives::exclusive_scan(in_place.data(), n, in_place.data());
      EXPECT_EQ(in_place, expected) << n;
    }
  });
}

TEST(CpuPrimitives, InclusiveSegmentedScan) {
  with_threads([] {
    for (const std::size_t n : kSizes)
      for (const std::uint32_t every : {1u, 7u, 3000u, 1000000u}) {
        const auto in = random_values(n, 1000, 2);
        const auto heads = random_flags(n, every, 3);
        std::vector<std::uint32_t> expected(n), out(n), in_place = in;
        for (std::size_t i = 0; i < n; ++i) expected[i] = (i == 0 || heads[i] != 0 ? 0 : expected[i - 1]) + in[i];
        CpuPrimitives::inclusive_segmented_scan(in.data(), heads.data(), n, out.data());
        EXPECT_EQ(out, expected) << n << ", a head in " << every;
        CpuPrimitives::inclusive_segmented_scan(in_place.data(), heads.data(), n, in_place.data());
        EXPECT_EQ(in_place, expected) << n << ", a head in " << every;
      }
  });
}

TEST(CpuPrimitives, Compact) {
  with_threads([] {
    for (const std::size_t n : kSizes)
      for (const std::uint32_t every : {1u, 5u, 4000u}) {
        const auto flags = random_flags(n, every, 4);
        std::vector<std::uint32_t> expected, out(n);
        for (std::uint32_t i = 0; i < n; ++i)
          if (flags[i] != 0) expected.push_back(i);
        out.resize(CpuPrimitives::compact(flags.data(), n, out.data()));
        EXPECT_EQ(out, expected) << n;
      }
  });
}

template <class Key>
void expect_stable_sort(std::vector<Key> keys) {
  std::vector<std::uint32_t> values(keys.size()), expected(keys.size());
  std::iota(values.begin(), values.end(), 0u), std::iota(expected.begin(), expected.end(), 0u);
  std::stable_sort(expected.begin(), expected.end(), [&](std::uint32_t a, std::uint32_t b) { return keys[a] < keys[b]; });
  std::vector<Key> sorted = keys;
  CpuPrimitives::sort_pairs(sorted.data(), values.data(), keys.size());
  EXPECT_EQ(values, expected);
  EXPECT_TRUE(std::is_sorted(sorted.begin(), sorted.end()));

  std::iota(values.begin(), values.end(), 0u);
  SerialPrimitives::sort_pairs(keys.data(), values.data(), keys.size());
  EXPECT_EQ(values, expected);
  EXPECT_EQ(keys, sorted);
}

// The masks leave out digits, at both ends and in between, so that the number of passes is even or odd.
TEST(CpuPrimitives, SortPairs) {
  with_threads([] {
    for (const std::size_t n : kSizes) {
      CounterRng rng(5, n);
      std::vector<std::uint64_t> random(n);
      for (std::uint64_t& key : random) key = rng.next_u64();
      for (const std::uint64_t mask : {~0ull, 0ull, 0xffull, 0xff00ff00ull, 0xffff000000ull, 0x3ull << 62}) {
        std::vector<std::uint64_t> wide;
        std::vector<std::uint32_t> narrow;
        for (const std::uint64_t key : random)
          wide.push_back(key & mask), narrow.push_back(static_cast<std::uint32_t>(key & mask));
        expect_stable_sort(wide);
        expect_stable_sort(narrow);
      }
    }
  });
}

}  // namespace
}  // namespace accel
