// Groups of rays against single rays, on every target that the machine has.
#include "libaccel/packet/ray_groups_simd.h"

#include <gtest/gtest.h>

#include <cstring>

#include "libaccel/exec/count_rays.h"
#include "libaccel/exec/cpu.h"
#include "libaccel/geometry/watertight.h"
#include "libaccel/trace/bvh2_stack.h"
#include "validation/unit/packet/packets_on_targets.h"

namespace accel {
namespace {

TEST(RayGroupsSimd, HitsAreThoseOfSingleRays) {
  std::size_t valid = 0;
  for (const auto& [name, mesh] : validation::stress_scenes()) {
    const Bvh2 tree = test::octo_tree(mesh);
    if (tree.root == kNoNode) continue;
    const test::PacketArrays arrays(mesh, tree);
    if (arrays.rays.empty()) continue;
    const LocalizedBatch batch = arrays.batch(tree);
    std::vector<Hit> expected(arrays.rays.size());
    std::vector<std::uint8_t> blocked(arrays.rays.size());
    trace_closest<Bvh2Stack<Watertight, Query::closest>>(tree.view(), arrays.rays, expected, 1);
    trace_any<Bvh2Stack<Watertight, Query::any>>(tree.view(), arrays.rays, blocked, 1);
    for (const Hit& hit : expected) valid += hit.valid();
    test::on_every_target([&, &scene = name] {
      std::vector<Hit> hits(arrays.rays.size());
      std::vector<std::uint8_t> occluded(arrays.rays.size());
      intersect_groups_simd(tree.view(), batch, arrays.faces.data(), hits.data());
      occlude_groups_simd(tree.view(), batch, arrays.faces.data(), occluded.data());
      EXPECT_EQ(std::memcmp(hits.data(), expected.data(), hits.size() * sizeof(Hit)), 0) << scene << packet_simd_target();
      EXPECT_EQ(occluded, blocked) << scene << packet_simd_target();
    });
  }
  EXPECT_GT(valid, 1000u);
}

// Copies of one ray fill a group, and step as one.
TEST(RayGroupsSimd, WorkIsCounted) {
  const auto scenes = validation::stress_scenes();
  const auto scene = std::ranges::find_if(scenes, [](const auto& s) { return s.mesh.size() > 100; });
  ASSERT_NE(scene, scenes.end());
  const Bvh2 tree = test::octo_tree(scene->mesh);
  const Vec3 e = tree.bounds.extent();
  const Ray ray{.org = tree.bounds.lo - e, .dir = e};
  const std::vector<std::uint32_t> zero{0};
  test::on_every_target([&] {
    const std::uint32_t count = 2 * rays_per_group();
    const std::vector<Ray> rays(count, ray);
    const std::vector<std::uint8_t> faces(count, static_cast<std::uint8_t>(face_of(ray)));
    std::vector<std::uint32_t> ids(count);
    std::iota(ids.begin(), ids.end(), 0u);
    const std::vector<std::uint32_t> packets{0, count};
    std::vector<Hit> hits(count);
    const LocalizedBatch batch{.leaves = tree.leaves.data(),
                               .rays = rays.data(),
                               .ids = ids.data(),
                               .packets = packets.data(),
                               .active = zero.data(),
                               .count = 1};
    const GroupWork work = intersect_groups_simd(tree.view(), batch, faces.data(), hits.data());
    const Counters single = count_rays<Bvh2Stack<Watertight, Query::closest>>(tree.view(), std::span(&ray, 1), {}, 1);
    EXPECT_EQ(work.nodes, 2 * single.node_steps);
    EXPECT_EQ(work.rays, count * single.node_steps);
    EXPECT_GT(work.nodes, 0u);
  });
}

}  // namespace
}  // namespace accel
