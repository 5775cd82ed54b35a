// The primitives of packet/cpu_primitives.h in plain loops: their twin in tests, and what serves blocks of rays that one thread
// takes through a whole pipeline by itself.
#pragma once

#include <algorithm>
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
    std::vector<std::pair<Key, std::uint32_t>> pairs(n);
    for (std::size_t i = 0; i < n; ++i) pairs[i] = {keys[i], values[i]};
    std::stable_sort(pairs.begin(), pairs.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    for (std::size_t i = 0; i < n; ++i) keys[i] = pairs[i].first, values[i] = pairs[i].second;
  }
};

}  // namespace accel
