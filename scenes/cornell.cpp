// The Cornell box, after Goral et al. 1984 as everybody knows it: an open room of side 2, a lamp, a short and a tall block.
// Every quad is cut into the same number of squares; at size 32 into one.
#include <cmath>
#include <numbers>

#include "scenes/generators.h"
#include "scenes/mesh_builder.h"

namespace accel {
namespace {

constexpr int kQuads = 16;  // five walls, a lamp, two blocks of five faces

// A block that stands on the floor, turned about the vertical by `degrees`.
void add_block(MeshBuilder& builder, Vec3d foot, double half_side, double height, double degrees, std::uint32_t divisions) {
  const double angle = degrees * std::numbers::pi / 180;
  const auto corner = [&](int i, double y) {
    const double turned = angle + i * (std::numbers::pi / 2);
    return foot + Vec3d{half_side * std::sqrt(2.0) * std::cos(turned), y, -half_side * std::sqrt(2.0) * std::sin(turned)};
  };
  for (int i = 0; i < 4; ++i)
    builder.add_quad(corner(i, 0), corner(i + 1, 0), corner(i + 1, height), corner(i, height), divisions);
  builder.add_quad(corner(0, height), corner(1, height), corner(2, height), corner(3, height), divisions);
}

}  // namespace

SceneData make_cornell(std::uint64_t size, std::uint64_t) {
  const std::uint32_t n = steps_for(static_cast<double>(size), 2 * kQuads);
  MeshBuilder builder;
  builder.add_quad({-1, 0, 1}, {1, 0, 1}, {1, 0, -1}, {-1, 0, -1}, n);                                  // floor
  builder.add_quad({-1, 2, -1}, {1, 2, -1}, {1, 2, 1}, {-1, 2, 1}, n);                                  // ceiling
  builder.add_quad({-1, 0, -1}, {1, 0, -1}, {1, 2, -1}, {-1, 2, -1}, n);                                // back
  builder.add_quad({-1, 0, 1}, {-1, 0, -1}, {-1, 2, -1}, {-1, 2, 1}, n);                                // left
  builder.add_quad({1, 0, -1}, {1, 0, 1}, {1, 2, 1}, {1, 2, -1}, n);                                    // right
  builder.add_quad({-0.25, 1.98, -0.2}, {0.25, 1.98, -0.2}, {0.25, 1.98, 0.2}, {-0.25, 1.98, 0.2}, n);  // lamp
  add_block(builder, {0.33, 0, 0.35}, 0.3, 0.6, 45 - 17, n);
  add_block(builder, {-0.35, 0, -0.3}, 0.3, 1.2, 45 + 17, n);

  // The light hangs just below the lamp, which would shade what it coincides with.
  const LightDescription light{{0, 1.975f, 0}, {0.25f, 0, 0}, {0, 0, 0.2f}};
  return {builder.build(), {{{0, 1, 3.9f}, {0, 1, 0}, {0, 1, 0}, 39, "default"}}, light};
}

}  // namespace accel
