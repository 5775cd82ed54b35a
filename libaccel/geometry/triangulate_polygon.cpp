#include "libaccel/geometry/triangulate_polygon.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace accel {
namespace {

void fan(std::span<const std::uint32_t> corners, IndexTriple* out) {
  for (std::size_t i = 2; i < corners.size(); ++i) *out++ = {corners[0], corners[i - 1], corners[i]};
}

}  // namespace

bool PolygonTriangulator::triangulate(std::span<const std::uint32_t> corners, std::span<const Vec3> vertices,
                                      IndexTriple* out) {
  const bool simple_case = corners.size() <= 3 || !project(corners, vertices) || is_strictly_convex();
  const bool too_large = !simple_case && corners.size() > kMaxConcaveCorners;
  if (simple_case || too_large)
    fan(corners, out);
  else
    clip_ears(corners, out);
  return !too_large;
}

// Fills points_. False when the polygon has no area or its positions are not finite.
bool PolygonTriangulator::project(std::span<const std::uint32_t> corners, std::span<const Vec3> vertices) {
  // Newell's normal; about the first corner, so that a small polygon far from the origin keeps its digits.
  const Vec3 origin = vertices[corners[0]];
  double normal[3] = {0, 0, 0};
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3 a = vertices[corners[i]], b = vertices[corners[i + 1 < corners.size() ? i + 1 : 0]];
    double p[3], q[3];
    for (int k = 0; k < 3; ++k) p[k] = double(a[k]) - origin[k], q[k] = double(b[k]) - origin[k];
    for (int k = 0; k < 3; ++k) normal[k] += p[(k + 1) % 3] * q[(k + 2) % 3] - p[(k + 2) % 3] * q[(k + 1) % 3];
  }
  int axis = 0;
  for (int k = 1; k < 3; ++k) axis = std::abs(normal[k]) > std::abs(normal[axis]) ? k : axis;
  if (!(std::abs(normal[axis]) > 0) || !std::isfinite(normal[0] + normal[1] + normal[2])) return false;

  // Exchanging the two coordinates mirrors the polygon, which makes a negative area positive.
  const int x = normal[axis] > 0 ? (axis + 1) % 3 : (axis + 2) % 3, y = 3 - axis - x;
  points_.clear();
  for (const std::uint32_t corner : corners) points_.push_back({vertices[corner][x], vertices[corner][y]});
  return true;
}

// Whether all turns are to the left and the boundary goes round once: then x rises and falls once.
bool PolygonTriangulator::is_strictly_convex() const {
  const std::size_t n = points_.size();
  int changes = 0;
  bool rising = points_[0].x >= points_[n - 1].x;
  for (std::size_t i = 0; i < n; ++i) {
    const Point a = points_[i], b = points_[(i + 1) % n], c = points_[(i + 2) % n];
    if (!(turn(a, b, c) > 0)) return false;
    if (b.x == a.x) continue;
    changes += (b.x > a.x) != rising;
    rising = b.x > a.x;
  }
  return changes <= 2;
}

double PolygonTriangulator::turn_at(std::uint32_t corner) const {
  return turn(points_[prev_[corner]], points_[corner], points_[next_[corner]]);
}

// Whether the triangle at a corner turns to the left and no other corner lies in it or on its border. Corners at the same place
// as one of its own (the two sides of a bridge to a hole) do not count.
bool PolygonTriangulator::is_ear(std::uint32_t corner) const {
  const Point a = points_[prev_[corner]], b = points_[corner], c = points_[next_[corner]];
  if (!(turn(a, b, c) > 0)) return false;
  const auto at = [](Point p, Point q) { return p.x == q.x && p.y == q.y; };
  for (const std::uint32_t blocker : blockers_) {
    const Point p = points_[blocker];
    if (at(p, a) || at(p, b) || at(p, c)) continue;
    if (turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0) return false;
  }
  return true;
}

// Finds out whether a corner is an ear, and queues it if so.
void PolygonTriangulator::judge(std::uint32_t corner) {
  is_ear_[corner] = is_ear(corner);
  if (is_ear_[corner]) queue_.push_back(corner);
}

// The ear that has waited longest, which spreads the triangles over the polygon instead of fanning them from one corner.
std::uint32_t PolygonTriangulator::take_ear() {
  while (queue_head_ < queue_.size()) {
    const std::uint32_t corner = queue_[queue_head_++];
    if (is_ear_[corner]) return corner;
  }
  return any_convex();
}

// What is cut off where there is no ear, because the polygon was not simple or what is left of it has no area.
std::uint32_t PolygonTriangulator::any_convex() const {
  std::uint32_t corner = some_corner_;
  do {
    if (turn_at(corner) > 0) return corner;
    corner = next_[corner];
  } while (corner != some_corner_);
  return corner;
}

void PolygonTriangulator::unlink(std::uint32_t corner) {
  const std::uint32_t before = prev_[corner], behind = next_[corner];
  next_[before] = behind, prev_[behind] = before;
  is_ear_[corner] = false;
  some_corner_ = behind;

  // The neighbours' angles have become smaller: they may have stopped being in the way.
  std::erase_if(blockers_, [&](std::uint32_t blocker) {
    return blocker == corner || ((blocker == before || blocker == behind) && turn_at(blocker) > 0);
  });
  judge(before), judge(behind);
}

void PolygonTriangulator::clip_ears(std::span<const std::uint32_t> corners, IndexTriple* out) {
  const auto n = static_cast<std::uint32_t>(corners.size());
  next_.resize(n), prev_.resize(n), is_ear_.assign(n, false);
  for (std::uint32_t i = 0; i < n; ++i) next_[i] = i + 1 < n ? i + 1 : 0, prev_[i] = i > 0 ? i - 1 : n - 1;

  blockers_.clear();
  for (std::uint32_t i = 0; i < n; ++i)
    if (!(turn_at(i) > 0)) blockers_.push_back(i);

  queue_.clear(), queue_head_ = 0, some_corner_ = 0;
  for (std::uint32_t i = 0; i < n; ++i) judge(i);

  for (std::uint32_t left = n; left > 2; --left) {
    const std::uint32_t ear = take_ear();
    *out++ = {corners[prev_[ear]], corners[ear], corners[next_[ear]]};
    unlink(ear);
  }
}

}  // namespace accel
