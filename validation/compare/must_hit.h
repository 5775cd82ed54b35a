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
  // `bounds` are those of `triangle`, which is possible and has an area. Triangles of different instances share no edges, even
  // where their vertices have the same coordinates: each is in its instance's space.
  void add(const Triangle& triangle, const TriangleBounds& bounds, std::uint32_t instance = 0);

  // Whether c is not in the row space of A, by elimination on sparse rows: an edge has two triangles as a rule, and parts of
  // the mesh that are not connected near the ray do not mix.
  bool decide() const;

 private:
  using Position = std::tuple<float, float, float>;
  using Edge = std::tuple<std::uint32_t, Position, Position>;  // of an instance
  using Columns = std::vector<std::uint32_t>;                  // of the ones in a row, ascending

  std::map<Edge, Columns> near_edges_;  // the rows of A
  Columns parities_;                    // c
  std::uint32_t triangles_ = 0;
  bool surely_inside_one_ = false;
};

}  // namespace accel::validation
