#include "libaccel/build/sort_words.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include <tbb/task_arena.h>

#include "libaccel/core/counter_rng.h"

namespace accel {
namespace {

std::vector<std::uint64_t> random_words(std::size_t n, std::uint64_t mask) {
  std::vector<std::uint64_t> words(n);
  for (std::size_t i = 0; i < n; ++i) {
    CounterRng rng(1, i);
    words[i] = rng.next_u64() & mask;
  }
  return words;
}

// By upper bits only, and stable; whatever digits there are, and in however many parts.
TEST(SortWords, EqualsKeepTheirOrderForAnyNumberOfThreads) {
  for (const std::uint64_t mask :
       {~std::uint64_t{0}, std::uint64_t{0}, std::uint64_t{0x7ff} << 42, std::uint64_t{3} << 62 | 0xff})
    for (const std::size_t n : {std::size_t{1}, std::size_t{100}, std::size_t{70000}})
      for (const int threads : {1, 2, 3})
        for (const int first_bit : {31, 42}) {
          std::vector<std::uint64_t> words = random_words(n, mask), expected = words, other(n);
          std::stable_sort(expected.begin(), expected.end(),
                           [=](std::uint64_t a, std::uint64_t b) { return a >> first_bit < b >> first_bit; });
          tbb::task_arena arena(threads);
          const std::uint64_t* const sorted =
              arena.execute([&] { return sort_words(words.data(), other.data(), n, first_bit); });
          EXPECT_TRUE(std::equal(expected.begin(), expected.end(), sorted)) << n << ' ' << threads << ' ' << first_bit;
        }
}

}  // namespace
}  // namespace accel
