// Work on the elements of arrays in parallel; element i is made from i alone, so the result does not depend on the threads.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cstddef>
#include <span>

namespace accel {

// Elements in one task.
inline constexpr std::size_t kFillBlock = 4096;

template <class Do>
void for_each_index(std::size_t count, const Do& make) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, kFillBlock), [&](const tbb::blocked_range<std::size_t>& block) {
    for (std::size_t i = block.begin(); i < block.end(); ++i) make(i);
  });
}

template <class T, class Make>
void fill(std::span<T> out, const Make& make) {
  for_each_index(out.size(), [&](std::size_t i) { out[i] = make(i); });
}

}  // namespace accel
