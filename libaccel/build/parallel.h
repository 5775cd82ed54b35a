// Parallel loops over arrays whose results do not depend on the number of threads: the array is cut into chunks of a fixed
// size, and what each chunk yields is combined in the chunks' order.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include <tbb/parallel_for.h>

namespace accel {

// Elements a chunk, and the size from which cutting pays.
inline constexpr std::size_t kChunk = 8192;
inline constexpr std::size_t kParallelSize = 4 * kChunk;

inline std::size_t chunk_count(std::size_t n) { return (n + kChunk - 1) / kChunk; }

// Calls body(chunk, begin, end) for each chunk of [begin, end), concurrently.
template <class Body>
void for_each_chunk(std::size_t begin, std::size_t end, const Body& body) {
  tbb::parallel_for(std::size_t{0}, chunk_count(end - begin), [&](std::size_t chunk) {
    const std::size_t first = begin + chunk * kChunk;
    body(chunk, first, std::min(first + kChunk, end));
  });
}

// The same, but calls directly where there is one chunk only.
template <class Body>
void for_chunks(std::size_t begin, std::size_t end, const Body& body) {
  if (begin == end) return;
  if (end - begin <= kChunk) {
    body(std::size_t{0}, begin, end);
  } else {
    for_each_chunk(begin, end, body);
  }
}

// Calls body(axis) for the three axes, concurrently if there is enough to do for `size` elements.
template <class Body>
void for_each_axis(std::size_t size, const Body& body) {
  if (size < kParallelSize) {
    for (int axis = 0; axis < 3; ++axis) body(axis);
  } else {
    tbb::parallel_for(0, 3, body);
  }
}

// The sum, by operator +=, of body(begin, end) over the chunks of [begin, end), or of the whole where it is small.
template <class Value, class Body>
Value reduce_chunks(std::size_t begin, std::size_t end, const Body& body) {
  if (end - begin < kParallelSize) return body(begin, end);
  std::vector<Value> parts(chunk_count(end - begin));
  for_each_chunk(begin, end, [&](std::size_t chunk, std::size_t b, std::size_t e) { parts[chunk] = body(b, e); });
  for (std::size_t i = 1; i < parts.size(); ++i) parts[0] += parts[i];
  return parts[0];
}

}  // namespace accel
