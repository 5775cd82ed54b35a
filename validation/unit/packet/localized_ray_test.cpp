#include "libaccel/packet/localized_ray.h"

#include <gtest/gtest.h>

#include <cstring>

#include "libaccel/exec/counters.h"
#include "libaccel/exec/drive.h"
#include "libaccel/exec/simt.h"
#include "libaccel/geometry/watertight.h"
#include "libaccel/packet/depth_first.h"
#include "validation/unit/packet/packets_of_rays.h"

namespace accel {
namespace {

// One ray, driven as any traverser and by the loop of packet/localized.h: the same hit, leaves and tests.
template <Query kQuery>
void expect_twins(const PacketLeaves& view, const Ray& ray, std::size_t& valid) {
  CountingObserver expected, counted;
  const Hit hit = intersect_leaves<Watertight, kQuery>(view.nodes, view.leaves, ray, view.places, view.count, expected);
  const Hit ours = trace_ray<LocalizedRay<Watertight, kQuery>>(view, ray, counted);
  ASSERT_EQ(std::memcmp(&ours, &hit, sizeof hit), 0);
  EXPECT_EQ(counted.counters.triangle_tests, expected.counters.triangle_tests);
  EXPECT_EQ(counted.counters.box_tests, expected.counters.box_tests);
  EXPECT_EQ(counted.counters.leaf_visits, expected.counters.leaf_visits);
  valid += hit.valid() ? 1 : 0;
}

TEST(LocalizedRay, FindsTheHitsOfIntersectLeaves) {
  std::size_t valid = 0;
  for (const auto& [name, mesh] : validation::stress_scenes()) {
    SCOPED_TRACE(name);
    const Bvh2 tree = test::octo_tree(mesh);
    if (tree.octo.empty()) continue;
    DepthFirst<> traversal;
    for (const auto& packet : test::packets_for(mesh, tree.bounds, 7)) {
      const Frustum frustum = test::frustum_of(packet, tree.bounds);
      const auto& found = traversal.run(tree.view(), &frustum, 1);
      const PacketLeaves view{tree.octo.data(), tree.leaves.data(), found.place.data(),
                              static_cast<std::uint32_t>(found.place.size())};
      std::vector<Hit> expected, hits(packet.size());
      for (const Ray& ray : packet) {
        expect_twins<Query::closest>(view, ray, valid);
        expect_twins<Query::any>(view, ray, valid);
        NullObserver observer;
        expected.push_back(trace_ray<LocalizedRay<Watertight, Query::closest>>(view, ray, observer));
      }
      const auto profile = simulate_simt<LocalizedRay<Watertight, Query::closest>>(view, packet, hits, {}, 1);
      EXPECT_EQ(std::memcmp(hits.data(), expected.data(), hits.size() * sizeof(Hit)), 0);
      EXPECT_EQ(profile.backtrack.steps, 0u);
      EXPECT_EQ(profile.of(Memory::stack).bytes, 0u);
    }
  }
  EXPECT_GT(valid, 1000u);
}

TEST(LocalizedRay, RaysOfNoWorkAreDoneAtOnce) {
  const Ray ray{.org = {0, 0, 0}, .dir = {0, 0, 1}};
  NullObserver observer;
  EXPECT_FALSE((trace_ray<LocalizedRay<Watertight, Query::closest>>(PacketLeaves{}, ray, observer)).valid());
}

}  // namespace
}  // namespace accel
