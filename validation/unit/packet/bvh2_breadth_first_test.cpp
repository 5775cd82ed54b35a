#include "libaccel/packet/bvh2_breadth_first.h"

#include <gtest/gtest.h>

#include <cstring>

#include "libaccel/exec/cpu.h"
#include "validation/unit/packet/packets_of_rays.h"

namespace accel {
namespace {

template <Query kQuery, class Answer>
std::vector<Answer> traced(const Bvh2View& view, const std::vector<Ray>& rays, const PacketOptions& options,
                           std::size_t& singly) {
  const auto single = [&](const Ray& ray) {
    NullObserver observer;
    ++singly;
    return trace_ray<Bvh2Stack<Watertight, kQuery>>(view, ray, observer);
  };
  std::vector<Answer> answers(rays.size());
  PacketTracer<Watertight, kQuery, decltype(single)>(view, options, single).trace(rays, answers);
  return answers;
}

TEST(Bvh2BreadthFirst, HitsAreThoseOfSingleRaysWhateverThePackets) {
  const PacketOptions all[] = {{},
                               {.max_size = 1, .min_size = 1},
                               {.max_size = 512, .block_size = 1000},
                               {.max_size = 33, .min_size = 1, .block_size = 7777},
                               {.block_size = 300, .cell_fraction = 0.1f},
                               {.max_width = 1e9f, .budget = 1000000},
                               {.budget = 0}};
  std::size_t valid = 0;
  for (const auto& [name, mesh] : validation::stress_scenes()) {
    const Bvh2 tree = test::octo_tree(mesh);
    if (tree.root == kNoNode) continue;
    const std::vector<Ray> rays = test::mixed_rays(mesh, tree.bounds);
    std::vector<Hit> expected(rays.size());
    std::vector<std::uint8_t> blocked(rays.size());
    trace_closest<Bvh2Stack<Watertight, Query::closest>>(tree.view(), rays, expected, 1);
    trace_any<Bvh2Stack<Watertight, Query::any>>(tree.view(), rays, blocked, 1);
    for (const Hit& hit : expected) valid += hit.valid();
    for (const PacketOptions& options : all) {
      std::size_t singly = 0;
      const auto hits = traced<Query::closest, Hit>(tree.view(), rays, options, singly);
      EXPECT_EQ(std::memcmp(hits.data(), expected.data(), hits.size() * sizeof(Hit)), 0) << name;
      EXPECT_EQ((traced<Query::any, std::uint8_t>(tree.view(), rays, options, singly)), blocked) << name;
      if (options.budget == 1000000 && !tree.octo.empty()) {
        EXPECT_LT(singly, rays.size() / 4) << "packets take part";
      }
    }
  }
  EXPECT_GT(valid, 10000u);
}

}  // namespace
}  // namespace accel
