// SIMD against its scalar twin, on every target that the machine has.
#include "libaccel/packet/localized_simd.h"

#include <gtest/gtest.h>

#include <cstring>

#include "libaccel/geometry/watertight.h"
#include "validation/unit/packet/packets_on_targets.h"

namespace accel {
namespace {

TEST(LocalizedSimd, HitsAreThoseOfTheScalarTwin) {
  std::size_t valid = 0;
  for (const auto& [name, mesh] : validation::stress_scenes()) {
    const Bvh2 tree = test::octo_tree(mesh);
    if (tree.octo.empty()) continue;
    const test::PacketArrays arrays(mesh, tree);
    const LocalizedBatch batch = arrays.batch(tree);
    std::vector<Hit> expected(arrays.rays.size());
    std::vector<std::uint8_t> blocked(arrays.rays.size());
    intersect_packets<Watertight, Query::closest>(batch, expected.data());
    intersect_packets<Watertight, Query::any>(batch, blocked.data());
    for (const Hit& hit : expected) valid += hit.valid();
    test::on_every_target([&, &scene = name] {
      std::vector<Hit> hits(arrays.rays.size());
      std::vector<std::uint8_t> occluded(arrays.rays.size());
      intersect_watertight_simd(batch, hits.data());
      occlude_watertight_simd(batch, occluded.data());
      EXPECT_EQ(std::memcmp(hits.data(), expected.data(), hits.size() * sizeof(Hit)), 0) << scene << packet_simd_target();
      EXPECT_EQ(occluded, blocked) << scene << packet_simd_target();
    });
  }
  EXPECT_GT(valid, 1000u);
}

}  // namespace
}  // namespace accel
