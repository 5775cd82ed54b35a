#include "libaccel/geometry/scene_data.h"

#include <gtest/gtest.h>

#include "validation/stress/stress_scenes.h"

namespace accel {
namespace {

// What counts is all that is placed, and what the meshes have.
TEST(SceneData, CountsPlacedTrianglesAndThoseOfMeshes) {
  const TriangleMesh mesh = validation::mesh_of(validation::random_triangles(1000, 0.1f, 1));
  SceneData scene;
  EXPECT_FALSE(scene.is_better_apart());
  for (const std::size_t copies : {kLargeMesh / 1000, kLargeMesh / 1000 + 1}) {
    scene.instances = *InstancedMeshes::make({mesh}, std::vector<Instance>(copies));
    EXPECT_EQ(scene.is_better_apart(), copies * 1000 >= kLargeMesh);
  }
}

}  // namespace
}  // namespace accel
