#include "scenes/sphere_grid.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace accel {
namespace {

// The largest r with 4 r^2 <= x.
std::uint64_t quarter_root(std::uint64_t x) {
  auto r = static_cast<std::uint64_t>(std::sqrt(static_cast<double>(x) / 4));
  while (4 * r * r > x) --r;
  while (4 * (r + 1) * (r + 1) <= x) ++r;
  return r;
}

}  // namespace

std::uint64_t SphereGrid::ring_size(std::uint64_t ring) const {
  return std::max<std::uint64_t>(1, 4 * std::min(ring, 2 * f_ - ring));
}

// One pole and rings of 4, 8, 12 ...: 1 + 2 r (r - 1) vertices come before ring r of the upper half; the lower half mirrors it.
std::uint64_t SphereGrid::ring_start(std::uint64_t ring) const {
  const auto before = [](std::uint64_t r) { return r == 0 ? 0 : 1 + 2 * r * (r - 1); };
  return ring <= f_ ? before(ring) : vertices() - before(2 * f_ - ring + 1);
}

std::uint32_t SphereGrid::at(std::uint64_t ring, std::uint64_t i) const {
  return static_cast<std::uint32_t>(ring_start(ring) + i % ring_size(ring));
}

Vec3d SphereGrid::vertex(std::uint32_t index) const {
  // Both halves start with their pole; half_index counts from there.
  const std::uint64_t equator_end = ring_start(f_) + 4 * f_;
  const bool upper = index < equator_end;
  const std::uint64_t from_pole = upper ? index : vertices() - 1 - index;
  std::uint64_t ring = 0;
  if (from_pole > 0) {
    ring = static_cast<std::uint64_t>((1 + std::sqrt(static_cast<double>(2 * from_pole - 1))) / 2);
    while (1 + 2 * ring * (ring - 1) > from_pole) --ring;
    while (1 + 2 * (ring + 1) * ring <= from_pole) ++ring;
  }
  if (!upper) ring = 2 * f_ - ring;

  const double step = static_cast<double>(index - ring_start(ring)) / static_cast<double>(ring_size(ring));
  const double polar = std::numbers::pi * static_cast<double>(ring) / static_cast<double>(2 * f_);
  const double azimuth = 2 * std::numbers::pi * step;
  if (ring == 0 || ring == 2 * f_) return {0, ring == 0 ? 1.0 : -1.0, 0};
  return {std::sin(polar) * std::cos(azimuth), std::cos(polar), -std::sin(polar) * std::sin(azimuth)};
}

IndexTriple SphereGrid::triangle(std::uint32_t index) const {
  // The lower half is the upper one seen in a mirror: rings count from the other pole and the winding turns.
  const bool upper = index < 4 * f_ * f_;
  const std::uint64_t i = upper ? index : index - 4 * f_ * f_;

  // Band r lies between rings r and r + 1; each of its four sectors has r + 1 triangles with their base on the outer ring and r
  // with their base on the inner ring, in turn.
  const std::uint64_t r = quarter_root(i), in_band = i - 4 * r * r;
  const std::uint64_t sector = in_band / (2 * r + 1), place = in_band % (2 * r + 1), k = place / 2;
  const auto inner = [&](std::uint64_t j) { return at(upper ? r : 2 * f_ - r, sector * r + j); };
  const auto outer = [&](std::uint64_t j) { return at(upper ? r + 1 : 2 * f_ - r - 1, sector * (r + 1) + j); };
  IndexTriple t =
      place % 2 == 0 ? IndexTriple{inner(k), outer(k), outer(k + 1)} : IndexTriple{inner(k), outer(k + 1), inner(k + 1)};
  if (!upper) std::swap(t.v1, t.v2);
  return t;
}

}  // namespace accel
