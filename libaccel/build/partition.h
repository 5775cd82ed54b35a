// Partitions of reference arrays in place, with the bounds of both sides.
//
// Deterministic: the order that results depends on the order before and on nothing else.
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "libaccel/build/parallel.h"
#include "libaccel/build/references.h"

namespace accel {

struct Partition {
  std::size_t middle = 0;  // the first reference of the right side
  SetBounds side[2];
};

namespace partition_detail {

// Moves the references of the left side to the front. The loop has no branch that depends on the references: each is swapped
// with the first one of the right side, which then moves on or not.
template <class IsRight>
Partition sequential(Reference* references, std::size_t begin, std::size_t end, const IsRight& is_right) {
  Partition result;
  std::size_t middle = begin;
  for (std::size_t i = begin; i < end; ++i) {
    const Reference reference = references[i];
    const Box4 box = reference.box();
    const bool right = is_right(reference, box);
    result.side[right].extend(box);
    references[i] = references[middle];
    references[middle] = reference;
    middle += right ? 0 : 1;
  }
  result.middle = middle;
  return result;
}

// A run of references that are on the wrong side of the middle.
struct Run {
  std::size_t begin, size, rank;  // rank: references in the runs before
};
inline void append_run(std::vector<Run>& runs, std::size_t begin, std::size_t end) {
  if (begin >= end) return;
  runs.push_back({begin, end - begin, runs.empty() ? 0 : runs.back().rank + runs.back().size});
}

// Exchanges the k-th misplaced reference of the one side with the k-th of the other, for k in [first, last).
inline void exchange(Reference* references, const std::vector<Run>& a, const std::vector<Run>& b, std::size_t first,
                     std::size_t last) {
  const auto run_of = [](const std::vector<Run>& runs, std::size_t k) {
    return std::upper_bound(runs.begin(), runs.end(), k, [](std::size_t x, const Run& run) { return x < run.rank; }) - 1;
  };
  auto ra = run_of(a, first), rb = run_of(b, first);
  for (std::size_t k = first; k < last; ++k) {
    if (k == ra->rank + ra->size) ++ra;
    if (k == rb->rank + rb->size) ++rb;
    std::swap(references[ra->begin + (k - ra->rank)], references[rb->begin + (k - rb->rank)]);
  }
}

// Each chunk is partitioned; then the right parts that lie left of the middle change places with the left parts that lie right
// of it.
template <class IsRight>
Partition parallel(Reference* references, std::size_t begin, std::size_t end, const IsRight& is_right) {
  std::vector<Partition> parts(chunk_count(end - begin));
  for_each_chunk(begin, end, [&](std::size_t chunk, std::size_t b, std::size_t e) {
    parts[chunk] = sequential(references, b, e, is_right);
  });
  Partition result;
  result.middle = begin;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    result.middle += parts[i].middle - (begin + i * kChunk);
    result.side[0] += parts[i].side[0], result.side[1] += parts[i].side[1];
  }

  std::vector<Run> misplaced_right, misplaced_left;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const std::size_t b = begin + i * kChunk, e = std::min(b + kChunk, end);
    append_run(misplaced_right, parts[i].middle, std::min(e, result.middle));
    append_run(misplaced_left, std::max(b, result.middle), parts[i].middle);
  }
  const std::size_t misplaced = misplaced_right.empty() ? 0 : misplaced_right.back().rank + misplaced_right.back().size;
  for_each_chunk(0, misplaced, [&](std::size_t, std::size_t first, std::size_t last) {
    exchange(references, misplaced_right, misplaced_left, first, last);
  });
  return result;
}

}  // namespace partition_detail

// Moves the references of [begin, end) for which is_right(reference, box) is false to the front. O(n), in parallel where n is
// large.
template <class IsRight>
Partition partition(Reference* references, std::size_t begin, std::size_t end, const IsRight& is_right) {
  return end - begin < kParallelSize ? partition_detail::sequential(references, begin, end, is_right)
                                     : partition_detail::parallel(references, begin, end, is_right);
}

// Splits in two halves at the median of the centres along the widest axis; ties go by prim_id. For sets that the heuristic
// cannot split, or must not. O(n) on average.
Partition partition_at_median(Reference* references, std::size_t begin, std::size_t end, const SetBounds& bounds);

}  // namespace accel
