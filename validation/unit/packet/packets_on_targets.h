// Packets as SIMD code takes them, and the targets that Highway compiled for.
#pragma once

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <algorithm>
#include <numeric>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "libaccel/packet/localized_simd.h"
#include "validation/unit/packet/packets_of_rays.h"

namespace accel::test {

// All packets of a scene, each against all leaves. Their rays lie in memory in runs of eight, the last run first, and some runs
// backwards: positions are not numbers.
struct PacketArrays {
  std::vector<Ray> rays;
  std::vector<std::uint32_t> ids, packets{0}, active, firsts, places;
  std::vector<std::uint8_t> faces;
  std::vector<Frustum> frustums;

  PacketArrays(const TriangleMesh& mesh, const Bvh2& tree) {
    for (const auto& packet : packets_for(mesh, tree.bounds, 3)) {
      rays.insert(rays.end(), packet.begin(), packet.end());
      packets.push_back(static_cast<std::uint32_t>(rays.size()));
      frustums.push_back(frustum_of(packet, tree.bounds));
      faces.resize(rays.size(), static_cast<std::uint8_t>(frustums.back().face));
      active.push_back(static_cast<std::uint32_t>(active.size()));
      firsts.push_back(static_cast<std::uint32_t>(places.size()));
      for (std::uint32_t i = 0; i < tree.octo.size() * kOctoArity; ++i)
        if (const NodeRef child = tree.octo[i / kOctoArity].child[i % kOctoArity]; child != kNoNode && is_leaf(child))
          places.push_back(kLeafBit | i);
    }
    firsts.push_back(static_cast<std::uint32_t>(places.size()));
    ids.resize(rays.size());
    std::iota(ids.rbegin(), ids.rend(), 0u);
    for (std::size_t run = 0; run + 8 <= ids.size(); run += 8)
      if (run % 48 != 0)
        std::reverse(ids.begin() + static_cast<std::ptrdiff_t>(run), ids.begin() + static_cast<std::ptrdiff_t>(run) + 8);
    const std::vector<Ray> by_position = std::exchange(rays, std::vector<Ray>(rays.size()));
    for (std::size_t i = 0; i < ids.size(); ++i) rays[ids[i]] = by_position[i];
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

}  // namespace accel::test
