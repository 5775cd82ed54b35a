#include "libaccel/registry/refit.h"

#include <gtest/gtest.h>

#include <vector>

#include "libaccel/core/affine.h"
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

InstancedMeshes two_placed_at(float x) {
  std::vector<Instance> instances(2);
  instances[1].transform = placed_by({1, 1, 1}, {0, 0, 1}, 0, {x, 0, 0});
  return *InstancedMeshes::make({test::soup(100, 0.4f)}, instances);
}

TEST(MoveInstancesOf, EveryMethodOfTheKindTracesWhatHasMoved) {
  const InstancedMeshes scene = two_placed_at(10), target = two_placed_at(20);
  const Ray ray{{20.1f, 0.2f, -9.0f}, 0.0f, {0.01f, -0.02f, 1.0f}, 100.0f};
  int able = 0;
  for (const MethodInfo& method : methods()) {
    SCOPED_TRACE(method.name);
    const auto accel = AnyAccel::build(scene, method.name);
    ASSERT_TRUE(accel) << accel.message();
    const auto moved = move_instances(*accel, target);
    EXPECT_EQ(moved.ok(), method.structure == "bvh8-levels");
    if (!moved) continue;
    ++able;
    EXPECT_EQ(moved->method().name, method.name);
    EXPECT_EQ(moved->report().triangles, 100u);
    EXPECT_EQ(moved->report().phases.size(), 3u);
    EXPECT_EQ(moved->report().notes.size(), accel->report().notes.size());
    const Hit hit = AnyAccel::build(target, "brute/loop")->closest(ray);
    EXPECT_TRUE(hit.valid());
    EXPECT_EQ(moved->closest(ray).prim_id, hit.prim_id);
    EXPECT_EQ(moved->closest(ray).t, hit.t);
    EXPECT_FALSE(accel->closest(ray).valid()) << "the handle stays as it is";
  }
  EXPECT_EQ(able, 2);
}

TEST(MoveInstancesOf, SaysWhatCan) {
  const auto accel = AnyAccel::build(two_placed_at(10), "bvh8/stream");
  EXPECT_EQ(move_instances(*accel, two_placed_at(20)).message(),
            "moving instances: a 'bvh8' cannot move them, a 'bvh8-levels' can (bvh8-instances); rebuild");
}

}  // namespace
}  // namespace accel
