// A pinhole camera: rays through the pixels of a picture.
#pragma once

#include <cstdint>

#include "libaccel/core/aabb.h"
#include "libaccel/core/camera_description.h"
#include "libaccel/core/ray.h"
#include "libaccel/core/result.h"
#include "libaccel/core/vec3d.h"

namespace accel {

class Camera {
 public:
  // A camera for pictures of width x height square pixels. Errors: eye equal to at, up parallel to the view, vfov outside (0,
  // 180), anything not finite or out of range, an empty picture.
  static Result<Camera> make(const CameraDescription& description, std::uint32_t width, std::uint32_t height);

  // The ray through the point (x, y) of the picture: (0, 0) is its upper left corner, (width, height) its lower right one, and
  // the centre of pixel (i, j) is (i + 0.5, j + 0.5). Its direction has unit length (to rounding), its interval is [0, inf].
  Ray ray(double x, double y) const;

  std::uint32_t width() const { return width_; }
  std::uint32_t height() const { return height_; }

 private:
  Vec3 eye_;
  Vec3d corner_;        // from the eye to the upper left corner of the picture, which lies at distance 1
  Vec3d right_, down_;  // one pixel's width and height in it
  std::uint32_t width_ = 0, height_ = 0;
};

// A view that shows all of the box, from above its front right corner (y is up). A box that is empty or out of range counts as
// the unit cube.
CameraDescription default_camera(const Aabb& bounds);

}  // namespace accel
