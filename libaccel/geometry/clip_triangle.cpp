#include "libaccel/geometry/clip_triangle.h"

#include <algorithm>
#include <cmath>

namespace accel {

inline ClippedPolygon::Point ClippedPolygon::crossing(const Point& p, const Point& q, double p_height, double q_height,
                                                      int axis, double position) {
  const double t = p_height / (p_height - q_height);
  Point point;
  for (int a = 0; a < 3; ++a) point.at[a] = p.at[a] + t * (q.at[a] - p.at[a]);
  point.at[axis] = position;
  return point;
}

inline void ClippedPolygon::Bounds::extend(const Point& point) {
  for (int a = 0; a < 3; ++a) {
    lo[a] = std::min(lo[a], point.at[a]);
    hi[a] = std::max(hi[a], point.at[a]);
  }
}

ClippedPolygon::ClippedPolygon(const Triangle& t)
    : points_{{{t.v0.x, t.v0.y, t.v0.z}}, {{t.v1.x, t.v1.y, t.v1.z}}, {{t.v2.x, t.v2.y, t.v2.z}}} {}

void ClippedPolygon::clip(const Aabb& box) {
  for (int axis = 0; axis < 3 && size_ > 0; ++axis) clip(axis, box.lo[axis], box.hi[axis]);
}

void ClippedPolygon::clip(int axis, double lo, double hi) {
  bool is_below = false, is_above = false;
  for (int i = 0; i < size_; ++i) {
    is_below |= points_[i].at[axis] < lo;
    is_above |= points_[i].at[axis] > hi;
  }
  if (is_below) keep_side(axis, lo, 1.0);
  if (is_below || is_above) keep_side(axis, hi, -1.0);  // points that the first cut adds may be off
}

void ClippedPolygon::keep_side(int axis, double position, double sign) {
  double height[kMaxPoints];
  int kept = 0;
  for (int i = 0; i < size_; ++i) {
    height[i] = sign * (points_[i].at[axis] - position);
    kept += height[i] >= 0 ? 1 : 0;
  }
  if (kept == size_) return;
  Point result[kMaxPoints];
  int size = 0;
  for (int i = 0; i < size_ && kept > 0; ++i) {
    const int next = i + 1 == size_ ? 0 : i + 1;
    if (height[i] >= 0 && size < kMaxPoints) result[size++] = points_[i];
    if ((height[i] >= 0) == (height[next] >= 0) || size == kMaxPoints) continue;
    result[size++] = crossing(points_[i], points_[next], height[i], height[next], axis, position);
  }
  size_ = size;
  for (int i = 0; i < size; ++i) points_[i] = result[i];
}

ClippedPolygon::Bounds ClippedPolygon::bounds_of_side(int axis, double position, double sign) const {
  Bounds bounds;
  if (size_ == 0) return bounds;
  const Point* previous = &points_[size_ - 1];
  double previous_height = sign * (previous->at[axis] - position);
  for (int i = 0; i < size_; ++i) {
    const Point& point = points_[i];
    const double height = sign * (point.at[axis] - position);
    if ((previous_height >= 0) != (height >= 0))
      bounds.extend(crossing(*previous, point, previous_height, height, axis, position));
    if (height >= 0) bounds.extend(point);
    previous = &point, previous_height = height;
  }
  return bounds;
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
