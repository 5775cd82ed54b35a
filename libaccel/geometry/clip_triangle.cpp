#include "libaccel/geometry/clip_triangle.h"

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
  Point in[kMaxPoints];
  for (int i = 0; i < size; ++i) in[i] = points_[i];
  size_ = 0;
  for (int i = 0; i < size; ++i) {
    const Point &p = in[i], &q = in[i + 1 == size ? 0 : i + 1];
    const double height_p = sign * (p.at[axis] - position), height_q = sign * (q.at[axis] - position);
    if (height_p >= 0 && size_ < kMaxPoints) points_[size_++] = p;
    if ((height_p >= 0) == (height_q >= 0) || size_ == kMaxPoints) continue;
    const double t = height_p / (height_p - height_q);
    Point& crossing = points_[size_++];
    for (int a = 0; a < 3; ++a) crossing.at[a] = p.at[a] + t * (q.at[a] - p.at[a]);
    crossing.at[axis] = position;
  }
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
