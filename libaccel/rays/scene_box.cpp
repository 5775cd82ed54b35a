#include "libaccel/rays/scene_box.h"

#include <algorithm>
#include <cmath>

#include "libaccel/core/ray.h"

namespace accel {
namespace {

float clamped(double x) { return static_cast<float>(std::clamp(x, -double{kMaxCoordinate}, double{kMaxCoordinate})); }

}  // namespace

Aabb enlarged(const Aabb& bounds, float share) {
  const Aabb box = bounds.empty() ? Aabb{{0, 0, 0}, {1, 1, 1}} : bounds;
  double largest = 0, farthest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    largest = std::max(largest, double{box.hi[axis]} - box.lo[axis]);
    farthest = std::max({farthest, std::fabs(double{box.lo[axis]}), std::fabs(double{box.hi[axis]})});
  }
  const double scale = largest > 0 ? largest : farthest > 0 ? farthest : 1.0;
  Aabb result;
  for (int axis = 0; axis < 3; ++axis) {
    result.lo[axis] = clamped(box.lo[axis] - share * scale);
    result.hi[axis] = clamped(box.hi[axis] + share * scale);
  }
  return result;
}

Vec3 point_in_box(const Aabb& box, CounterRng& rng) {
  const auto between = [&](float lo, float hi) { return static_cast<float>(lo + (double{hi} - lo) * rng.next_double()); };
  const float x = between(box.lo.x, box.hi.x), y = between(box.lo.y, box.hi.y), z = between(box.lo.z, box.hi.z);
  return {x, y, z};
}

}  // namespace accel
