#include "libaccel/registry/refit.h"

#include <gtest/gtest.h>

#include "validation/unit/build/test_meshes.h"

namespace accel {
namespace {

TriangleMesh scaled(const TriangleMesh& mesh, float factor) {
  TriangleMesh result = mesh;
  result.vertices = Buffer<Vec3>::copy_of(mesh.vertices.span());
  for (Vec3& v : result.vertices) v = factor * v;
  return result;
}

TEST(Refit, EveryMethodOfTheKindTracesWhatHasMoved) {
  const TriangleMesh mesh = test::soup(500, 0.4f), target = scaled(mesh, 2.0f);
  int refitted = 0;
  for (const MethodInfo& method : methods()) {
    SCOPED_TRACE(method.name);
    if (method.instances) continue;
    const auto accel = AnyAccel::build(mesh, method.name);
    ASSERT_TRUE(accel) << accel.message();
    const auto moved = refit(*accel, target);
    EXPECT_EQ(moved.ok(), method.structure == "bvh8");
    if (!moved) continue;
    ++refitted;
    EXPECT_EQ(moved->accel.method().name, method.name);
    EXPECT_EQ(moved->accel.report().triangles, 500u);
    const auto built = AnyAccel::build(target, "brute/loop");
    const Ray ray{{0.1f, 0.2f, -9.0f}, 0.0f, {0.01f, -0.02f, 1.0f}, 100.0f};
    EXPECT_TRUE(built->closest(ray).valid());
    EXPECT_EQ(moved->accel.closest(ray).prim_id, built->closest(ray).prim_id);
    EXPECT_EQ(moved->accel.closest(ray).t, built->closest(ray).t);
  }
  EXPECT_GE(refitted, 2);
}

TEST(Refit, OtherTrianglesAreRefused) {
  const auto accel = AnyAccel::build(test::soup(100, 0.4f), "bvh8-fast/stream");
  for (const std::size_t triangles : {0, 99, 101}) {
    const auto moved = refit(*accel, test::soup(triangles, 0.4f));
    ASSERT_FALSE(moved);
    EXPECT_NE(moved.message().find("built over 100"), std::string::npos) << moved.message();
  }
  TriangleMesh broken = test::soup(100, 0.4f);
  broken.triangles[7].v1 = 1000000;
  EXPECT_FALSE(refit(*accel, broken));
}

}  // namespace
}  // namespace accel
