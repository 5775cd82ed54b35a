#include "libaccel/geometry/clip_triangle.h"

#include <algorithm>
#include <cmath>

namespace accel {

ClippedPolygon::ClippedPolygon(const Triangle& t)
    : points_{{{t.v0.x, t.v0.y, t.v0.z}}, {{t.v1.x, t.v1.y, t.v1.z}}, {{t.v2.x, t.v2.y, t.v2.z}}} {}

void ClippedPolygon::clip(const Aabb& box) {
  for (int axis = 0; axis < 3 && size_ > 0; ++axis) {
    clip(axis, box.lo[axis], 1.0);
    clip(axis, box.hi[axis], -1.0);
  }
}

void ClippedPolygon::clip(int axis, double position, double sign) {
  const int size = size_;
  double height[kMaxPoints];
  int kept = 0;
  for (int i = 0; i < size; ++i) {
    height[i] = sign * (points_[i].at[axis] - position);
    kept += height[i] >= 0 ? 1 : 0;
  }
  if (kept == size) return;
  size_ = 0;
  if (kept == 0) return;

  Point in[kMaxPoints];
  for (int i = 0; i < size; ++i) in[i] = points_[i];
  for (int i = 0; i < size; ++i) {
    const int next = i + 1 == size ? 0 : i + 1;
    const Point &p = in[i], &q = in[next];
    if (height[i] >= 0 && size_ < kMaxPoints) points_[size_++] = p;
    if ((height[i] >= 0) == (height[next] >= 0) || size_ == kMaxPoints) continue;
    const double t = height[i] / (height[i] - height[next]);
    Point& crossing = points_[size_++];
    for (int a = 0; a < 3; ++a) crossing.at[a] = p.at[a] + t * (q.at[a] - p.at[a]);
    crossing.at[axis] = position;
  }
}

ClippedPolygon::Range ClippedPolygon::range(int axis) const {
  Range range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (int i = 0; i < size_; ++i) {
    range.lo = std::min(range.lo, points_[i].at[axis]);
    range.hi = std::max(range.hi, points_[i].at[axis]);
  }
  return range;
}

double ClippedPolygon::area() const {
  double normal[3] = {0, 0, 0};
  for (int i = 1; i + 1 < size_; ++i) {
    double e[3], f[3];
    for (int a = 0; a < 3; ++a) e[a] = points_[i].at[a] - points_[0].at[a], f[a] = points_[i + 1].at[a] - points_[0].at[a];
    for (int a = 0; a < 3; ++a) normal[a] += e[(a + 1) % 3] * f[(a + 2) % 3] - e[(a + 2) % 3] * f[(a + 1) % 3];
  }
  return 0.5 * std::hypot(normal[0], normal[1], normal[2]);
}

bool ClippedPolygon::is_inside(const Aabb& box) const {
  for (int i = 0; i < size_; ++i)
    for (int a = 0; a < 3; ++a)
      if (!(points_[i].at[a] >= box.lo[a] && points_[i].at[a] <= box.hi[a])) return false;
  return true;
}

}  // namespace accel
