#include "libaccel/build/sort_words.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "libaccel/build/parallel.h"
#include "libaccel/build/radix_sort.h"

namespace accel {
namespace {

constexpr std::size_t kDigits = std::size_t{1} << kWordDigitBits;
using Histogram = std::array<std::uint32_t, kDigits>;

std::size_t digit_of(std::uint64_t word, int shift) { return word >> shift & (kDigits - 1); }

// As many parts as threads, each large enough for its histogram not to matter: the order does not depend on them.
class Parts {
 public:
  explicit Parts(std::size_t n) : n_(n) {
    const auto threads = static_cast<std::size_t>(std::max(tbb::this_task_arena::max_concurrency(), 1));
    count_ = std::clamp<std::size_t>(n / (2 * kChunk), 1, threads);
  }
  std::size_t count() const { return count_; }

  template <class Body>
  void for_each(const Body& body) const {
    const auto call = [&](std::size_t part) { body(part, n_ * part / count_, n_ * (part + 1) / count_); };
    if (count_ == 1)
      call(0);
    else
      tbb::parallel_for(std::size_t{0}, count_, call);
  }

 private:
  std::size_t n_, count_;
};

}  // namespace

std::uint64_t* sort_words(std::uint64_t* words, std::uint64_t* other, std::size_t n, int first_bit) {
  const Parts parts(n);
  std::vector<Histogram> counts(parts.count());
  for (int shift = first_bit; shift < 64; shift += kWordDigitBits) {
    parts.for_each([&](std::size_t part, std::size_t begin, std::size_t end) {
      Histogram& count = counts[part];
      count.fill(0);
      for (std::size_t i = begin; i < end; ++i) ++count[digit_of(words[i], shift)];
    });
    if (!radix_detail::place_digits(counts, n)) continue;
    parts.for_each([&](std::size_t part, std::size_t begin, std::size_t end) {
      Histogram& next = counts[part];
      for (std::size_t i = begin; i < end; ++i) other[next[digit_of(words[i], shift)]++] = words[i];
    });
    std::swap(words, other);
  }
  return words;
}

}  // namespace accel
