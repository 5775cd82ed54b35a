// The way in which a triangle is written down does not matter. Laws that concern all methods' answers: laws_test.cpp.
#include <utility>

#include "validation/conformance/method_test.h"
#include "validation/stress/stress_rays.h"
#include "validation/stress/stress_scenes.h"

namespace accel::validation {
namespace {

class Metamorphic : public MethodTest {};

// Turning a triangle around moves its u and v, not its t. Other tests round their three edges in different ways.
TEST_P(Metamorphic, WindingDoesNotMatter) {
  const std::vector<Triangle> triangles = random_triangles(300, 0.3f, 33);
  std::vector<Triangle> turned = triangles;
  for (Triangle& t : turned) std::swap(t.v1, t.v2);
  const TriangleMesh mesh = mesh_of(triangles);
  const std::vector<Ray> rays = stress_rays(mesh, 2000, 24);
  const std::vector<std::uint8_t> before = occluded(build(mesh), rays), after = occluded(build(mesh_of(turned)), rays);
  std::size_t different = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) different += before[i] != after[i];
  EXPECT_EQ(different, 0u);
}

}  // namespace

ACCEL_FOR_EVERY_PROMISE(Metamorphic);

}  // namespace accel::validation
