// The parallel primitives that batch pipelines are written in, on oneTBB: for_each, exclusive_scan, inclusive_segmented_scan,
// compact and sort_pairs, as Garanzha and Loop 2010, "Fast Ray Sorting and Breadth-First Packet Traversal for GPU Ray Tracing"
// [GL10], section 2.1, use them.
//
// A pipeline is a template over a type like this one, with the same functions on arrays in the memory of its machine. They run
// in the calling thread's arena, and what they write does not depend on the number of threads. Sizes are below 2^32. All may
// throw std::bad_alloc.
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

struct CpuPrimitives {
  template <class T>
  using Array = Buffer<T>;

  // body(i) for each i below n, concurrently.
  template <class Body>
  static void for_each(std::size_t n, const Body& body) {
    for_chunks(0, n, [&](std::size_t, std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) body(i);
    });
  }

  // out[i] is the sum of in[j] for all j < i; returns the sum of all. `out` may be `in`.
  template <class T>
  static T exclusive_scan(const T* in, std::size_t n, T* out) {
    std::vector<T> before(chunk_count(n));
    for_chunks(0, n, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
      T sum{};
      for (std::size_t i = begin; i < end; ++i) sum += in[i];
      before[chunk] = sum;
    });
    const T total = scan_serially(before.data(), before.size(), before.data());
    for_chunks(0, n, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
      scan_serially(in + begin, end - begin, out + begin, before[chunk]);
    });
    return total;
  }

  // out[i] is the sum of in[j] from the last j <= i with heads[j] != 0 on, or from 0 on where there is none. `out` may be `in`.
  template <class T>
  static void inclusive_segmented_scan(const T* in, const std::uint8_t* heads, std::size_t n, T* out) {
    struct Tail {
      T sum;  // since the chunk's last head, or of the whole chunk
      bool has_head;
    };
    std::vector<Tail> tails(chunk_count(n));
    for_chunks(0, n, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
      std::size_t i = end;
      T sum{};
      bool has_head = false;
      while (i > begin && !has_head) sum += in[--i], has_head = heads[i] != 0;
      tails[chunk] = {sum, has_head};
    });
    std::vector<T> before(tails.size());
    for (std::size_t c = 1; c < tails.size(); ++c)
      before[c] = tails[c - 1].has_head ? tails[c - 1].sum : before[c - 1] + tails[c - 1].sum;
    for_chunks(0, n, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
      T sum = before[chunk];
      for (std::size_t i = begin; i < end; ++i) {
        sum = heads[i] != 0 ? in[i] : sum + in[i];
        out[i] = sum;
      }
    });
  }

  // The indices i with flags[i] != 0, in order; returns how many. `out` has room for n.
  static std::size_t compact(const std::uint8_t* flags, std::size_t n, std::uint32_t* out) {
    std::vector<std::size_t> before(chunk_count(n));
    for_chunks(0, n, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
      before[chunk] = static_cast<std::size_t>(end - begin) - std::count(flags + begin, flags + end, std::uint8_t{0});
    });
    const std::size_t total = scan_serially(before.data(), before.size(), before.data());
    for_chunks(0, n, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
      std::uint32_t* next = out + before[chunk];
      for (std::size_t i = begin; i < end; ++i)
        if (flags[i] != 0) *next++ = static_cast<std::uint32_t>(i);
    });
    return total;
  }

  // Sorts keys in ascending order, and the values with them; equal keys keep their order. A radix sort by digits of 8 bits:
  // O(n) for each digit in which keys differ.
  template <class Key>
  static void sort_pairs(Key* keys, std::uint32_t* values, std::size_t n) {
    static_assert(std::is_unsigned_v<Key>);
    Buffer<Key> other_keys(n);
    Buffer<std::uint32_t> other_values(n);
    Pairs<Key> from{keys, values}, to{other_keys.data(), other_values.data()};
    for (std::size_t shift = 0; shift < 8 * sizeof(Key); shift += 8)
      if (sort_by_digit(from, to, n, static_cast<int>(shift))) std::swap(from, to);
    if (from.keys == keys) return;
    for_each(n, [&](std::size_t i) { keys[i] = from.keys[i], values[i] = from.values[i]; });
  }

 private:
  template <class Key>
  struct Pairs {
    Key* keys;
    std::uint32_t* values;
  };
  using Histogram = std::array<std::uint32_t, 256>;

  template <class T>
  static T scan_serially(const T* in, std::size_t n, T* out, T sum = {}) {
    for (std::size_t i = 0; i < n; ++i) {
      const T value = in[i];
      out[i] = sum;
      sum += value;
    }
    return sum;
  }

  // Turns the counts of each chunk's digits into where they go. False, with nothing of use in them, if there is one digit only.
  static bool place_digits(std::vector<Histogram>& counts, std::size_t n) {
    std::uint32_t next = 0;
    for (std::size_t digit = 0; digit < 256; ++digit) {
      const std::uint32_t first = next;
      for (Histogram& count : counts) next += std::exchange(count[digit], next);
      if (next - first == n) return false;
    }
    return true;
  }

  // One pass. False, and nothing done, if all keys have the same digit.
  template <class Key>
  static bool sort_by_digit(const Pairs<Key>& from, const Pairs<Key>& to, std::size_t n, int shift) {
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
};

}  // namespace accel
