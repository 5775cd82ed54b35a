// Packets through a Bvh8 against single rays, on every target that the machine has.
#include "libaccel/packet/bvh8_packets_simd.h"

#include <gtest/gtest.h>

#include <cstring>

#include "libaccel/build/wide_sbvh.h"
#include "libaccel/exec/cpu.h"
#include "libaccel/geometry/watertight.h"
#include "libaccel/trace/bvh8_ordered.h"
#include "validation/unit/build/test_meshes.h"
#include "validation/unit/packet/packets_on_targets.h"

namespace accel {
namespace {

TEST(Bvh8PacketsSimd, HitsAreThoseOfSingleRays) {
  std::size_t valid = 0;
  for (const auto& [name, mesh] : validation::stress_scenes()) {
    const Bvh8 tree = WideSbvh::build(mesh, {})->structure;
    if (is_leaf(tree.root)) continue;
    const test::PacketArrays arrays(mesh, test::octo_tree(mesh));
    if (arrays.rays.empty()) continue;
    const LocalizedBatch batch = arrays.batch(Bvh2{});
    std::vector<Hit> expected(arrays.rays.size());
    std::vector<std::uint8_t> blocked(arrays.rays.size());
    NullObserver observer;
    for (std::size_t i = 0; i < arrays.rays.size(); ++i) {
      expected[i] = trace_ray<Bvh8Ordered<Watertight, Query::closest>>(tree.view(), arrays.rays[i], observer);
      blocked[i] = expected[i].valid() ? 1 : 0;
      valid += blocked[i];
    }
    test::on_every_target([&, &scene = name] {
      std::vector<Hit> hits(arrays.rays.size());
      std::vector<std::uint8_t> occluded(arrays.rays.size());
      trace_bvh8_packets_simd(tree.view(), batch, arrays.faces.data(), hits.data());
      for (const bool from_far_end : {false, true}) {
        std::fill(occluded.begin(), occluded.end(), 7);
        trace_bvh8_packets_simd(tree.view(), batch, arrays.faces.data(), occluded.data(), from_far_end);
        EXPECT_EQ(occluded, blocked) << scene << packet_simd_target();
      }
      EXPECT_EQ(std::memcmp(hits.data(), expected.data(), hits.size() * sizeof(Hit)), 0) << scene << packet_simd_target();
    });
  }
  EXPECT_GT(valid, 1000u);
}

}  // namespace
}  // namespace accel
