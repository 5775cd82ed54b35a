// A cubic grid of closed spheres: every edge is shared by two triangles, so a ray that enters through one must leave through
// another.
#include <algorithm>
#include <cmath>

#include "libaccel/core/counter_rng.h"
#include "scenes/generators.h"
#include "scenes/mesh_builder.h"

namespace accel {
namespace {

constexpr double kTrianglesPerSphere = 2048;  // about, before the number of spheres is rounded

}  // namespace

SceneData make_spheres(std::uint64_t size, std::uint64_t seed) {
  const double wanted = static_cast<double>(size);
  const auto side = static_cast<std::uint32_t>(std::max(1.0, std::round(std::cbrt(wanted / kTrianglesPerSphere))));
  const std::uint32_t count = side * side * side;
  const std::uint32_t frequency = steps_for(wanted / count, 8);

  MeshBuilder builder;
  for (std::uint32_t i = 0; i < count; ++i) {
    CounterRng rng(seed, i);
    const Vec3d cell{static_cast<double>(i % side), static_cast<double>(i / side % side), static_cast<double>(i / side / side)};
    const double radius = 0.25 + 0.2 * rng.next_double();
    builder.add_sphere(frequency, [=](Vec3d unit) { return cell + unit * radius; });
  }
  const float middle = static_cast<float>(side - 1) / 2, far = static_cast<float>(side);
  const CameraDescription camera{
      {middle + 0.9f * far, middle + 0.7f * far, middle + 1.5f * far}, {middle, middle, middle}, {0, 1, 0}, 40, "default"};
  return {builder.build(), {camera}, {}};
}

}  // namespace accel
