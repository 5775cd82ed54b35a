// A parallel radix sort of keys with the values that belong to them.
//
// By digits of 8 bits, the least first; each chunk counts its digits and then moves its pairs to where they go. Stable, and the
// same for any number of threads. O(n) for each digit in which keys differ; room for the pairs once more. May throw
// std::bad_alloc. Sizes are below 2^32.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <type_traits>
#include <utility>
#include <vector>

#include "libaccel/build/parallel.h"
#include "libaccel/core/buffer.h"

namespace accel {

inline constexpr int kRadixBits = 8;

namespace radix_detail {

template <class Key>
struct Pairs {
  Key* keys;
  std::uint32_t* values;
};
using Histogram = std::array<std::uint32_t, 1u << kRadixBits>;

// Turns the counts of each chunk's digits into where they go. False, with nothing of use in them, if there is one digit only.
template <std::size_t kDigits>
bool place_digits(std::vector<std::array<std::uint32_t, kDigits>>& counts, std::size_t n) {
  std::uint32_t next = 0;
  for (std::size_t digit = 0; digit < kDigits; ++digit) {
    const std::uint32_t first = next;
    for (auto& count : counts) next += std::exchange(count[digit], next);
    if (next - first == n) return false;
  }
  return true;
}

// One pass. False, and nothing done, if all keys have the same digit.
template <class Key>
bool sort_by_digit(const Pairs<Key>& from, const Pairs<Key>& to, std::size_t n, int shift) {
  const auto digit_of = [&](std::size_t i) { return static_cast<std::size_t>(from.keys[i] >> shift & 0xff); };
  std::vector<Histogram> counts(chunk_count(n));
  for_chunks(0, n, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
    Histogram count{};
    for (std::size_t i = begin; i < end; ++i) ++count[digit_of(i)];
    counts[chunk] = count;
  });
  if (!place_digits(counts, n)) return false;
  for_chunks(0, n, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
    Histogram next = counts[chunk];
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t place = next[digit_of(i)]++;
      to.keys[place] = from.keys[i], to.values[place] = from.values[i];
    }
  });
  return true;
}

}  // namespace radix_detail

// Sorts by the keys; equals keep their order.
template <class Key>
void radix_sort(Key* keys, std::uint32_t* values, std::size_t n) {
  static_assert(std::is_unsigned_v<Key>);
  Buffer<Key> other_keys(n);
  Buffer<std::uint32_t> other_values(n);
  radix_detail::Pairs<Key> from{keys, values}, to{other_keys.data(), other_values.data()};
  for (int shift = 0; shift < 8 * static_cast<int>(sizeof(Key)); shift += kRadixBits)
    if (radix_detail::sort_by_digit(from, to, n, shift)) std::swap(from, to);
  if (from.keys == keys) return;
  for_chunks(0, n, [&](std::size_t, std::size_t begin, std::size_t end) {
    std::copy(from.keys + begin, from.keys + end, keys + begin);
    std::copy(from.values + begin, from.values + end, values + begin);
  });
}

}  // namespace accel
