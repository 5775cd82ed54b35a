// The parallel primitives that batch pipelines are written in, on oneTBB: for_each, exclusive_scan, inclusive_segmented_scan,
// compact and sort_pairs, as Garanzha and Loop 2010, "Fast Ray Sorting and Breadth-First Packet Traversal for GPU Ray Tracing"
// [GL10], section 2.1, use them.
//
// A pipeline is a template over a type like this one, with the same functions on arrays in the memory of its machine. They run
// in the calling thread's arena, and what they write does not depend on the number of threads. Sizes are below 2^32. All may
// throw std::bad_alloc.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "libaccel/build/parallel.h"
#include "libaccel/build/radix_sort.h"
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
    radix_sort(keys, values, n);
  }

 private:
  template <class T>
  static T scan_serially(const T* in, std::size_t n, T* out, T sum = {}) {
    for (std::size_t i = 0; i < n; ++i) {
      const T value = in[i];
      out[i] = sum;
      sum += value;
    }
    return sum;
  }
};

}  // namespace accel
