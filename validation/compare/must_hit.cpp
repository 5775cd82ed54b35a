#include "validation/compare/must_hit.h"

#include <bit>

namespace accel::validation {
namespace {

using Bits = std::vector<std::uint64_t>;

void flip(Bits& bits, std::size_t i) {
  if (bits.size() <= i / 64) bits.resize(i / 64 + 1, 0);
  bits[i / 64] ^= std::uint64_t{1} << (i % 64);
}

bool test(const Bits& bits, std::size_t i) { return i / 64 < bits.size() && (bits[i / 64] >> (i % 64) & 1); }

void add_to(Bits& sum, const Bits& bits) {
  if (sum.size() < bits.size()) sum.resize(bits.size(), 0);
  for (std::size_t i = 0; i < bits.size(); ++i) sum[i] ^= bits[i];
}

constexpr std::size_t kNone = ~std::size_t{0};

std::size_t first_one(const Bits& bits) {
  for (std::size_t i = 0; i < bits.size(); ++i) {
    if (bits[i] != 0) return 64 * i + static_cast<std::size_t>(std::countr_zero(bits[i]));
  }
  return kNone;
}

// Whether an edge crosses the half-axis x > 0, y = 0. The same for both directions of the edge.
bool crosses(const FrameVertex& p, const FrameVertex& q) {
  if ((p.y >= 0) == (q.y >= 0)) return false;
  const FrameVertex& below = p.y >= 0 ? q : p;
  const FrameVertex& above = p.y >= 0 ? p : q;
  return below.x * above.y - below.y * above.x > 0;
}

}  // namespace

void MustHit::add(const Triangle& triangle, const TriangleBounds& bounds) {
  const std::size_t column = triangles_++;
  const auto position = [](Vec3 v) { return Position{v.x, v.y, v.z}; };
  const Position positions[3] = {position(triangle.v0), position(triangle.v1), position(triangle.v2)};
  bool inside = false;
  for (int i = 0; i < 3; ++i) {
    const int p = (i + 1) % 3, q = (i + 2) % 3;
    inside ^= crosses(bounds.vertex[p], bounds.vertex[q]);
    if (bounds.edge_near[i]) flip(near_edges_[std::minmax(positions[p], positions[q])], column);
  }
  if (inside) flip(parities_, column);
  surely_inside_one_ |= inside && !bounds.near_any_edge();
}

bool MustHit::decide() const {
  if (surely_inside_one_) return true;

  // An echelon form of the rows: each basis row is the only one with its pivot as first bit; what is left of c decides.
  std::map<std::size_t, Bits> basis;
  const auto reduce = [&](Bits row) {
    for (auto& [pivot, basis_row] : basis) {
      if (test(row, pivot)) add_to(row, basis_row);
    }
    return row;
  };
  for (const auto& [edge, bits] : near_edges_) {
    Bits row = reduce(bits);
    const std::size_t pivot = first_one(row);
    if (pivot != kNone) basis.emplace(pivot, std::move(row));
  }
  return first_one(reduce(parities_)) != kNone;
}

}  // namespace accel::validation
