#include "validation/compare/must_hit.h"

#include <algorithm>
#include <iterator>
#include <unordered_map>

namespace accel::validation {
namespace {

using Columns = std::vector<std::uint32_t>;

Columns sum(const Columns& a, const Columns& b) {
  Columns result;
  std::set_symmetric_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(result));
  return result;
}

// Adds 1 to the entry of the last column, which is the largest so far.
void flip_last(Columns& row, std::uint32_t column) {
  if (!row.empty() && row.back() == column) {
    row.pop_back();
  } else {
    row.push_back(column);
  }
}

// Whether an edge crosses the half-axis x > 0, y = 0. The same for both directions of the edge.
bool crosses(const FrameVertex& p, const FrameVertex& q) {
  if ((p.y >= 0) == (q.y >= 0)) return false;
  const FrameVertex& below = p.y >= 0 ? q : p;
  const FrameVertex& above = p.y >= 0 ? p : q;
  return below.x * above.y - below.y * above.x > 0;
}

}  // namespace

void MustHit::add(const Triangle& triangle, const TriangleBounds& bounds, std::uint32_t instance) {
  const std::uint32_t column = triangles_++;
  const auto position = [](Vec3 v) { return Position{v.x, v.y, v.z}; };
  const Position positions[3] = {position(triangle.v0), position(triangle.v1), position(triangle.v2)};
  bool inside = false;
  for (int i = 0; i < 3; ++i) {
    const int p = (i + 1) % 3, q = (i + 2) % 3;
    inside ^= crosses(bounds.vertex[p], bounds.vertex[q]);
    const auto [from, to] = std::minmax(positions[p], positions[q]);
    if (bounds.edge_near[i]) flip_last(near_edges_[Edge{instance, from, to}], column);
  }
  if (inside) flip_last(parities_, column);
  surely_inside_one_ |= inside && !bounds.near_any_edge();
}

bool MustHit::decide() const {
  if (surely_inside_one_) return true;

  // An echelon form: rows by their first column, each column once. Reducing from the front ends at a row that is no sum of the
  // others, or at nothing.
  std::unordered_map<std::uint32_t, Columns> basis;
  const auto reduce = [&](Columns row) {
    while (!row.empty()) {
      const auto pivot = basis.find(row.front());
      if (pivot == basis.end()) break;
      row = sum(row, pivot->second);
    }
    return row;
  };
  for (const auto& [edge, columns] : near_edges_) {
    Columns row = reduce(columns);
    if (!row.empty()) basis.emplace(row.front(), std::move(row));
  }
  return !reduce(parities_).empty();
}

}  // namespace accel::validation
