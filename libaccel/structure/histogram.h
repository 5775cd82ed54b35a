// Histograms of the statistics of structures.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace accel {

// One more at a place, which need not exist yet.
inline void count_in(std::vector<std::uint64_t>& histogram, std::size_t at) {
  if (histogram.size() <= at) histogram.resize(at + 1);
  ++histogram[at];
}

// One more with a number, as distinct numbers are counted: returns whether it is the first. Memory: a bit for each number.
inline bool is_first(std::vector<bool>& seen, std::uint32_t number) {
  if (number >= seen.size()) seen.resize(std::max<std::size_t>(std::size_t{number} + 1, 2 * seen.size()));
  const bool first = !seen[number];
  seen[number] = true;
  return first;
}

}  // namespace accel
