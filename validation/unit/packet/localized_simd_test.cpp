// SIMD against its scalar twin, on every target that the machine has.
#include "libaccel/packet/localized_simd.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cstring>
#include <numeric>
#include <set>
#include <string>

#include "libaccel/geometry/watertight.h"
#include "libaccel/packet/frustums_simd.h"
#include "validation/unit/packet/packets_of_rays.h"

namespace accel {
namespace {

// All packets of a scene, each against all leaves.
struct Arrays {
  std::vector<Ray> rays;
  std::vector<std::uint32_t> ids, packets{0}, active, firsts, places;
  std::vector<std::uint8_t> faces;
  std::vector<Frustum> frustums;

  Arrays(const TriangleMesh& mesh, const Bvh2& tree) {
    for (const auto& packet : test::packets_for(mesh, tree.bounds, 3)) {
      rays.insert(rays.end(), packet.begin(), packet.end());
      packets.push_back(static_cast<std::uint32_t>(rays.size()));
      frustums.push_back(test::frustum_of(packet, tree.bounds));
      faces.resize(rays.size(), static_cast<std::uint8_t>(frustums.back().face));
      active.push_back(static_cast<std::uint32_t>(active.size()));
      firsts.push_back(static_cast<std::uint32_t>(places.size()));
      for (std::uint32_t i = 0; i < tree.octo.size() * kOctoArity; ++i)
        if (const NodeRef child = tree.octo[i / kOctoArity].child[i % kOctoArity]; child != kNoNode && is_leaf(child))
          places.push_back(kLeafBit | i);
    }
    firsts.push_back(static_cast<std::uint32_t>(places.size()));
    ids.resize(rays.size());
    std::iota(ids.rbegin(), ids.rend(), 0u);  // backwards: positions are not numbers
    std::reverse(rays.begin(), rays.end());
  }
  LocalizedBatch batch(const Bvh2& tree) const {
    return {tree.octo.data(), tree.leaves.data(), rays.data(),   ids.data(),    packets.data(),
            active.data(),    frustums.data(),    firsts.data(), active.size(), places.data()};
  }
};

template <class Body>
void on_every_target(const Body& body) {
  std::set<std::string> ran;
  for (const auto target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    EXPECT_STREQ(packet_simd_target(), hwy::TargetName(target));
    ran.insert(packet_simd_target());
    body();
  }
  hwy::SetSupportedTargetsForTest(0);
  EXPECT_FALSE(ran.empty());
}

TEST(LocalizedSimd, HitsAreThoseOfTheScalarTwin) {
  std::size_t valid = 0;
  for (const auto& [name, mesh] : validation::stress_scenes()) {
    const Bvh2 tree = test::octo_tree(mesh);
    if (tree.octo.empty()) continue;
    const Arrays arrays(mesh, tree);
    const LocalizedBatch batch = arrays.batch(tree);
    std::vector<Hit> expected(arrays.rays.size());
    std::vector<std::uint8_t> blocked(arrays.rays.size());
    intersect_packets<Watertight, Query::closest>(batch, expected.data());
    intersect_packets<Watertight, Query::any>(batch, blocked.data());
    for (const Hit& hit : expected) valid += hit.valid();
    on_every_target([&, &scene = name] {
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

TEST(LocalizedSimd, FrustumsAreThoseOfTheScalarTwin) {
  for (const auto& [name, mesh] : validation::stress_scenes()) {
    const Bvh2 tree = test::octo_tree(mesh);
    if (tree.octo.empty()) continue;
    const Arrays arrays(mesh, tree);
    on_every_target([&, &scene = name] {
      std::vector<Frustum> frustums(arrays.frustums.size());
      make_frustums_simd(arrays.batch(tree), arrays.faces.data(), tree.bounds, frustums.data());
      for (std::size_t f = 0; f < frustums.size(); ++f)
        ASSERT_EQ(std::memcmp(&frustums[f], &arrays.frustums[f], sizeof(Frustum)), 0) << scene << packet_simd_target();
    });
  }
}

}  // namespace
}  // namespace accel
