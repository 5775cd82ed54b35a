#include "libaccel/rays/offset_origin.h"

#include <algorithm>
#include <cmath>

#include "libaccel/core/float_bounds.h"

namespace accel {
namespace {

double largest_component(Vec3d v) { return std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)}); }

// The normal of the triangle on the side that a ray with direction `dir` comes from.
Vec3d facing_normal(Vec3d v0, Vec3d v1, Vec3d v2, Vec3d dir) {
  const Vec3d normal = cross(v1 - v0, v2 - v0);
  if (!(dot(normal, normal) > 0)) return -normalized(dir);
  return dot(normal, dir) > 0 ? -normalized(normal) : normalized(normal);
}

// The float next to x on the side that `outwards` points to.
float round_outwards(double x, double outwards) {
  return outwards > 0 ? round_up(x) : outwards < 0 ? round_down(x) : static_cast<float>(x);
}

}  // namespace

SurfacePoint offset_origin(const Triangle& triangle, const Hit& hit, Vec3 dir, double position_error) {
  const Vec3d v0(triangle.v0), v1(triangle.v1), v2(triangle.v2);
  const double b1 = hit.u, b2 = hit.v, b0 = 1.0 - b1 - b2;
  const Vec3d p = v0 * b0 + v1 * b1 + v2 * b2;
  const Vec3d normal = facing_normal(v0, v1, v2, Vec3d(dir));

  // The bound that the header derives.
  const double extent = std::max({largest_component(v0 - p), largest_component(v1 - p), largest_component(v2 - p)});
  const double error = gamma(16) * extent + 0x1p-50 * (extent + largest_component(p)) + position_error;
  const double norm_1 = std::fabs(normal.x) + std::fabs(normal.y) + std::fabs(normal.z);

  const Vec3d o = p + normal * (norm_1 * error);
  return {{round_outwards(o.x, normal.x), round_outwards(o.y, normal.y), round_outwards(o.z, normal.z)}, normal};
}

}  // namespace accel
