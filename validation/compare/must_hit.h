// Whether every way of moving the vertices within their bounds leaves some triangle around the ray: the argument is in judge.h.
#pragma once

#include <cstdint>
#include <map>
#include <tuple>
#include <utility>
#include <vector>

#include "validation/compare/error_bounds.h"

namespace accel::validation {

// Collects the triangles of N, then decides. One ray, one use.
class MustHit {
 public:
  // `bounds` are those of `triangle`, which is possible and has an area.
  void add(const Triangle& triangle, const TriangleBounds& bounds);

  // Whether c is not in the row space of A. O(edges * rank * triangles / 64), for a handful of triangles in practice.
  bool decide() const;

 private:
  using Position = std::tuple<float, float, float>;
  using Edge = std::pair<Position, Position>;
  using Bits = std::vector<std::uint64_t>;  // one bit a triangle, as many words as are needed

  std::map<Edge, Bits> near_edges_;  // the rows of A
  Bits parities_;                    // c
  std::size_t triangles_ = 0;
  bool surely_inside_one_ = false;
};

}  // namespace accel::validation
