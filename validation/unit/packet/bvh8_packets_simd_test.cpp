// Packets through a Bvh8 against single rays, on every target that the machine has.
#include "libaccel/packet/bvh8_packets_simd.h"

#include <gtest/gtest.h>

#include <cstring>

#include "libaccel/build/wide_sbvh.h"
#include "libaccel/core/float_bounds.h"
#include "libaccel/exec/cpu.h"
#include "libaccel/geometry/watertight.h"
#include "libaccel/trace/bvh8_instances.h"
#include "libaccel/trace/bvh8_ordered.h"
#include "validation/stress/stress_instances.h"
#include "validation/unit/build/built_instances.h"
#include "validation/unit/build/test_meshes.h"
#include "validation/unit/packet/packets_on_targets.h"

namespace accel {
namespace {

// Packets around a mesh. Returns how many rays hit something.
template <class Traverser, class View>
std::size_t expect_hits_of_single_rays(const std::string& scene, const View& view, const TriangleMesh& mesh) {
  const test::PacketArrays arrays(mesh, test::octo_tree(mesh));
  if (arrays.rays.empty()) return 0;
  const LocalizedBatch batch = arrays.batch(Bvh2{});
  std::vector<Hit> expected(arrays.rays.size());
  std::vector<std::uint8_t> blocked(arrays.rays.size());
  std::size_t valid = 0;
  NullObserver observer;
  for (std::size_t i = 0; i < arrays.rays.size(); ++i) {
    expected[i] = trace_ray<Traverser>(view, arrays.rays[i], observer);
    blocked[i] = expected[i].valid() ? 1 : 0;
    valid += blocked[i];
  }
  test::on_every_target([&] {
    std::vector<Hit> hits(arrays.rays.size());
    std::vector<std::uint8_t> occluded(arrays.rays.size());
    trace_bvh8_packets_simd(view, batch, arrays.faces.data(), hits.data());
    for (const bool from_far_end : {false, true}) {
      std::fill(occluded.begin(), occluded.end(), 7);
      trace_bvh8_packets_simd(view, batch, arrays.faces.data(), occluded.data(), from_far_end);
      EXPECT_EQ(occluded, blocked) << scene << packet_simd_target();
    }
    EXPECT_EQ(std::memcmp(hits.data(), expected.data(), hits.size() * sizeof(Hit)), 0) << scene << packet_simd_target();
  });
  return valid;
}

TEST(Bvh8PacketsSimd, HitsAreThoseOfSingleRays) {
  std::size_t valid = 0;
  for (const auto& [name, mesh] : validation::stress_scenes()) {
    const Bvh8 tree = WideSbvh::build(mesh, {})->structure;
    if (!is_leaf(tree.root))
      valid += expect_hits_of_single_rays<Bvh8Ordered<Watertight, Query::closest>>(name, tree.view(), mesh);
  }
  EXPECT_GT(valid, 1000u);
}

// Also where a leaf has several instances: one node above them, in a tree of any depth.
TEST(Bvh8PacketsSimd, HitsInInstancesAreThoseOfSingleRays) {
  std::size_t valid = 0, runs = 0;
  for (const int depth : {1, 120})
    for (const auto& [name, scene] : validation::instanced_scenes(8)) {
      const TwoLevelBvh8 levels = test::built<WideInstances>(scene, {.max_depth = depth});
      if (is_leaf(levels.root)) continue;
      const auto in_world = scene.flattened();
      ASSERT_TRUE(in_world) << in_world.message();
      valid += expect_hits_of_single_rays<Bvh8Instances<Watertight, Query::closest>>(name, levels.view(), *in_world);
      for (const Bvh8Instance& instance : levels.instances) runs += 1 - instance.ends_leaf;
    }
  EXPECT_GT(valid, 1000u);
  EXPECT_GT(runs, 10u);
}

// Any-hit packets decide most rays by bounds of t: limits at t, and next to it, are what these cannot tell.
struct Limited {
  std::size_t limited = 0, open = 0;  // rays whose interval begins or ends there, and those of them that meet nothing

  template <template <class, Query> class Traverser, class View>
  void expect_hits_of_single_rays(const std::string& scene, const View& view, const TriangleMesh& mesh) {
    test::PacketArrays arrays(mesh, test::octo_tree(mesh));
    NullObserver observer;
    std::vector<std::uint8_t> blocked(arrays.rays.size());
    for (std::size_t i = 0; i < arrays.rays.size(); ++i) {
      Ray& ray = arrays.rays[i];
      const Hit hit = trace_ray<Traverser<Watertight, Query::closest>>(view, ray, observer);
      const bool is_limited = hit.valid() && hit.t > 0;
      if (is_limited) {
        const float ends[] = {hit.t, next_down(hit.t), hit.t * (1 + 0x1p-20f), hit.t * (1 - 0x1p-20f)};
        const float begins[] = {0, hit.t, next_up(hit.t)};
        ray.t_max = i % 6 == 5 ? ray.t_max : ends[i % 4], ray.t_min = i % 6 == 5 ? begins[i / 6 % 3] : 0;
      }
      blocked[i] = trace_ray<Traverser<Watertight, Query::any>>(view, ray, observer).valid() ? 1 : 0;
      limited += is_limited ? 1 : 0, open += is_limited && blocked[i] == 0 ? 1 : 0;
    }
    const LocalizedBatch batch = arrays.batch(Bvh2{});
    test::on_every_target([&] {
      std::vector<std::uint8_t> occluded(arrays.rays.size(), 7);
      trace_bvh8_packets_simd(view, batch, arrays.faces.data(), occluded.data(), false);
      EXPECT_EQ(occluded, blocked) << scene << packet_simd_target();
    });
  }
  ~Limited() {
    EXPECT_GT(limited, 1000u);
    EXPECT_GT(open, limited / 8);
    EXPECT_LT(open, limited * 7 / 8);
  }
};

TEST(Bvh8PacketsSimd, AnyHitsBeginAndEndWithTheirInterval) {
  Limited rays;
  for (const auto& [name, mesh] : validation::stress_scenes()) {
    const Bvh8 tree = WideSbvh::build(mesh, {})->structure;
    if (!is_leaf(tree.root)) rays.expect_hits_of_single_rays<Bvh8Ordered>(name, tree.view(), mesh);
  }
}

TEST(Bvh8PacketsSimd, AnyHitsInInstancesBeginAndEndWithTheirInterval) {
  Limited rays;
  for (const auto& [name, scene] : validation::instanced_scenes(10)) {
    const TwoLevelBvh8 levels = test::built<WideInstances>(scene);
    if (!is_leaf(levels.root)) rays.expect_hits_of_single_rays<Bvh8Instances>(name, levels.view(), *scene.flattened());
  }
}

}  // namespace
}  // namespace accel
