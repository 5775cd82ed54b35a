// The primitives of packet/cpu_primitives.h in plain loops: their twin in tests, and what serves blocks of rays that one thread
// takes through a whole pipeline by itself.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <type_traits>
#include <utility>
#include <vector>

#include "libaccel/core/buffer.h"

namespace accel {

struct SerialPrimitives {
  template <class T>
  using Array = Buffer<T>;

  template <class Body>
  static void for_each(std::size_t n, const Body& body) {
    for (std::size_t i = 0; i < n; ++i) body(i);
  }

  template <class T>
  static T exclusive_scan(const T* in, std::size_t n, T* out) {
    T sum{};
    for (std::size_t i = 0; i < n; ++i) {
      const T value = in[i];
      out[i] = sum;
      sum += value;
    }
    return sum;
  }

  template <class T>
  static void inclusive_segmented_scan(const T* in, const std::uint8_t* heads, std::size_t n, T* out) {
    T sum{};
    for (std::size_t i = 0; i < n; ++i) {
      sum = heads[i] != 0 ? in[i] : sum + in[i];
      out[i] = sum;
    }
  }

  static std::size_t compact(const std::uint8_t* flags, std::size_t n, std::uint32_t* out) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < n; ++i) {
      out[count] = static_cast<std::uint32_t>(i);  // overwritten unless flagged: cheaper than a branch
      count += flags[i] != 0;
    }
    return count;
  }

  template <class Key>
  static void sort_pairs(Key* keys, std::uint32_t* values, std::size_t n) {
    static_assert(std::is_unsigned_v<Key>);
    std::vector<Key> other_keys(n);
    std::vector<std::uint32_t> other_values(n);
    Key *from = keys, *to = other_keys.data();
    std::uint32_t *from_values = values, *to_values = other_values.data();
    for (std::size_t shift = 0; shift < 8 * sizeof(Key); shift += 8) {
      const auto digit = [=](Key key) { return static_cast<std::size_t>(key >> shift & 0xff); };
      std::array<std::uint32_t, 256> next{};
      for (std::size_t i = 0; i < n; ++i) ++next[digit(from[i])];
      if (n == 0 || next[digit(from[0])] == n) continue;  // one digit only
      std::exclusive_scan(next.begin(), next.end(), next.begin(), 0u);
      for (std::size_t i = 0; i < n; ++i) {
        const std::uint32_t at = next[digit(from[i])]++;
        to[at] = from[i], to_values[at] = from_values[i];
      }
      std::swap(from, to), std::swap(from_values, to_values);
    }
    if (from == keys) return;
    std::copy_n(from, n, keys), std::copy_n(from_values, n, values);
  }
};

}  // namespace accel
