#include "libaccel/packet/frustum.h"

#include <gtest/gtest.h>

#include "libaccel/packet/localized.h"
#include "validation/unit/packet/packets_of_rays.h"

namespace accel {
namespace {

// On which all else rests: a frustum meets every box that one of its rays enters.
TEST(Frustum, MeetsWhatItsRaysEnter) {
  std::uint64_t entered = 0, culled = 0;
  for (const auto& [name, mesh] : validation::stress_scenes()) {
    const Bvh2 tree = test::octo_tree(mesh);
    if (tree.octo.empty()) continue;
    for (const std::vector<Ray>& packet : test::packets_for(mesh, tree.bounds, 1)) {
      const Frustum frustum = test::frustum_of(packet, tree.bounds);
      for (const OctoNode& node : tree.octo)
        for (std::uint32_t c = 0; c < kOctoArity; ++c) {
          if (node.child[c] == kNoNode) continue;
          const bool enters_any = std::any_of(packet.begin(), packet.end(), [&](const Ray& ray) {
            return enters(node, c, ScalarBoxPairTest::prepare(ray, first_t(ray)),
                          min_of(ray.t_max, std::numeric_limits<float>::max()));
          });
          const bool meets = frustum.meets(node.bounds(c));
          entered += enters_any, culled += !meets;
          ASSERT_TRUE(meets || !enters_any) << name;
        }
    }
  }
  EXPECT_GT(entered, 1000u);
  EXPECT_GT(culled, 1000u);
}

TEST(Frustum, IsTightAroundBundles) {
  const Aabb bounds{{-10, -10, -10}, {10, 10, 10}};
  const std::vector<Ray> packet{{.org = {0, 0, 0}, .dir = {1, 0.1f, 0}}, {.org = {0, 0, 0}, .dir = {1, -0.1f, 0.1f}}};
  const Frustum frustum = test::frustum_of(packet, bounds);
  const auto meets = [&](Vec3 lo, Vec3 hi) { return frustum.meets({lo, hi}); };
  EXPECT_TRUE(meets({5, 0, 0}, {6, 0.1f, 0.1f}));
  EXPECT_TRUE(meets({5, 0.49f, 0}, {5.1f, 1, 1}));
  EXPECT_FALSE(meets({4, 0.52f, 0}, {5, 1, 1})) << "above";
  EXPECT_FALSE(meets({5, 0, -1}, {6, 0.1f, -0.01f})) << "below the other side";
  EXPECT_FALSE(meets({-6, -1, -1}, {-0.01f, 1, 1})) << "behind";
}

TEST(Frustum, OfRaysThatMissTheSceneMeetsNothing) {
  const Aabb bounds{{0, 0, 0}, {1, 1, 1}};
  const std::vector<Ray> packet{{.org = {5, 0, 0}, .dir = {1, 0, 0}}};
  EXPECT_FALSE(test::frustum_of(packet, bounds).meets(bounds));
}

TEST(Faces, TellAxisAndSign) {
  EXPECT_EQ(face_of({.dir = {1, 0.5f, 0}}), 0u);
  EXPECT_EQ(face_of({.dir = {0, -2, 1}}), 3u);
  EXPECT_EQ(face_of({.dir = {0, 0, 1}}), 4u);
  EXPECT_EQ(face_of({.dir = {0, 0, 0}}), kNoFace);
  EXPECT_EQ(face_of({.dir = {1, 1e-39f, 0}}), kNoFace) << "1 / dir overflows";
  for (const Ray& ray : validation::invalid_rays()) EXPECT_EQ(face_of(ray), kNoFace);
}

}  // namespace
}  // namespace accel
