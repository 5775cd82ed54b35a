#include "libaccel/rays/camera.h"

#include <cmath>
#include <numbers>
#include <string>

#include "libaccel/core/float_bounds.h"

namespace accel {
namespace {

Error camera_error(const CameraDescription& description, const std::string& what) {
  return Error{"camera" + (description.name.empty() ? "" : " '" + description.name + "'") + ": " + what};
}

double radians(double degrees) { return degrees * (std::numbers::pi / 180.0); }

// The sine of the angle between two unit vectors below which single-precision input cannot tell them from parallel ones.
constexpr double kParallelSine = gamma(4);

}  // namespace

Result<Camera> Camera::make(const CameraDescription& c, std::uint32_t width, std::uint32_t height) {
  if (width == 0 || height == 0) return camera_error(c, "the picture is empty; width and height must be at least 1");
  if (!in_range(c.eye) || !in_range(c.at) || !in_range(c.up))
    return camera_error(c, "eye, at or up is not finite or out of range");
  if (!(c.vfov_degrees > 0.0f && c.vfov_degrees < 180.0f))
    return camera_error(c, "vfov is " + std::to_string(c.vfov_degrees) + " degrees; it must lie between 0 and 180");
  if (c.eye == c.at) return camera_error(c, "eye and at are the same point; move one of them");
  if (c.up == Vec3{}) return camera_error(c, "up is zero; give a direction such as 0,1,0");

  // The picture's frame: forward, right and up, each of unit length.
  const Vec3d forward = normalized(Vec3d(c.at) - Vec3d(c.eye));
  const Vec3d side = cross(forward, normalized(Vec3d(c.up)));
  if (!(length(side) > kParallelSine)) return camera_error(c, "up is parallel to the view; choose another up");
  const Vec3d right = normalized(side), up = cross(right, forward);

  // The picture at distance 1.
  const double half_height = std::tan(radians(c.vfov_degrees) / 2), pixel = 2 * half_height / height;
  Camera camera;
  camera.eye_ = c.eye;
  camera.right_ = right * pixel, camera.down_ = up * -pixel;
  camera.corner_ = forward + up * half_height - right * (pixel * width / 2);
  camera.width_ = width, camera.height_ = height;
  return camera;
}

Ray Camera::ray(double x, double y) const {
  return {.org = eye_, .dir = normalized(corner_ + right_ * x + down_ * y).to_float()};
}

CameraDescription default_camera(const Aabb& bounds) {
  const bool usable = !bounds.empty() && in_range(bounds.lo) && in_range(bounds.hi);
  const Vec3d lo(usable ? bounds.lo : Vec3{}), hi(usable ? bounds.hi : Vec3{1, 1, 1});
  const Vec3d center = (lo + hi) * 0.5;

  // Far enough that the sphere around the box fits into the picture's height. A box that is one point gets a sphere that floats
  // can tell from it.
  const double point_radius = std::max(1.0, 1e-3 * length(center));
  const double radius = lo.x == hi.x && lo.y == hi.y && lo.z == hi.z ? point_radius : length(hi - lo) * 0.5;
  CameraDescription camera;
  const double distance = radius / std::sin(radians(camera.vfov_degrees) / 2);
  camera.eye = (center + normalized({0.5, 0.45, 1.0}) * distance).to_float();
  camera.at = center.to_float();
  camera.name = "default";
  return camera;
}

}  // namespace accel
