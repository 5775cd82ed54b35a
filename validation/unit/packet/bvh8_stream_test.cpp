#include "libaccel/packet/bvh8_stream.h"

#include <gtest/gtest.h>

#include <cstring>

#include "libaccel/build/wide_sbvh.h"
#include "libaccel/exec/cpu.h"
#include "libaccel/geometry/woop.h"
#include "validation/unit/build/test_meshes.h"
#include "validation/unit/packet/packets_of_rays.h"

namespace accel {
namespace {

template <class Test>
void expect_single_rays_answers(const std::string& name, const Bvh8View& view, std::span<const Ray> rays,
                                const BatchSettings& settings) {
  std::vector<Hit> hits(rays.size(), Hit{1, 2, 3, 4}), expected(rays.size());
  std::vector<std::uint8_t> occluded(rays.size(), 7), blocked(rays.size());
  NullObserver observer;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    expected[i] = trace_ray<Bvh8Ordered<Test, Query::closest>>(view, rays[i], observer);
    blocked[i] = expected[i].valid() ? 1 : 0;
  }
  trace_closest<Bvh8Stream<Test, Query::closest>>(view, rays, hits, settings);
  trace_any<Bvh8Stream<Test, Query::any>>(view, rays, occluded, settings);
  EXPECT_TRUE(rays.empty() || std::memcmp(hits.data(), expected.data(), hits.size() * sizeof(Hit)) == 0) << name;
  EXPECT_EQ(occluded, blocked) << name;
}

TEST(Bvh8Stream, HitsAreThoseOfSingleRaysWhateverThePackets) {
  const PacketOptions all[] = {{},
                               {.max_size = 1, .min_size = 1},
                               {.max_size = 100000, .block_size = 1000},
                               {.max_size = 33, .min_size = 1, .block_size = 257},
                               {.min_size = 1000000},
                               {.max_size = 0, .block_size = 1}};
  for (const auto& [name, mesh] : validation::stress_scenes()) {
    const Bvh8 tree = WideSbvh::build(mesh, {})->structure;
    const std::vector<Ray> rays = test::mixed_rays(mesh, tree.bounds);
    ASSERT_TRUE(are_alike(std::span(rays).first(2000)));
    for (const PacketOptions& options : all) expect_single_rays_answers<Watertight>(name, tree.view(), rays, {2, options});
    for (const std::size_t few : {0, 1, 7, 255})
      expect_single_rays_answers<Watertight>(name, tree.view(), std::span(rays).first(few), 1);
  }
}

// Blocks that are large enough for trials: rays go all ways.
TEST(Bvh8Stream, HitsAreThoseOfSingleRaysInTrials) {
  const TriangleMesh mesh = test::soup(2000, 0.1f);
  const Bvh8 tree = WideSbvh::build(mesh, {})->structure;
  const auto camera = Camera::make(default_camera(tree.bounds), 160, 120);
  ASSERT_TRUE(camera) << camera.message();
  const auto primary = primary_rays(*camera);
  ASSERT_TRUE(are_alike(primary->rays.span()));
  for (const std::uint32_t block_size : {32768u, 7000u})
    for (const int threads : {1, 2})
      expect_single_rays_answers<Watertight>("soup", tree.view(), primary->rays.span(), {threads, {.block_size = block_size}});
}

TEST(Bvh8Stream, WithAnotherTriangleTest) {
  const TriangleMesh mesh = test::soup(500, 0.3f);
  const Bvh8 tree = WideSbvh::build(mesh, {})->structure;
  expect_single_rays_answers<Woop>("soup", tree.view(), test::mixed_rays(mesh, tree.bounds), 1);
}

TEST(Bvh8Stream, OfNothing) {
  const Bvh8 tree = WideSbvh::build(TriangleMesh{}, {})->structure;
  const std::vector<Ray> rays(300, Ray{.org = {0, 0, 0}, .dir = {0, 0, 1}});
  expect_single_rays_answers<Watertight>("empty", tree.view(), rays, 1);
}

TEST(Bvh8Stream, RaysAreAlike) {
  std::vector<Ray> rays(1000);
  for (std::size_t i = 0; i < rays.size(); ++i) rays[i].dir = {1, static_cast<float>(i) * 0.01f, 0};
  EXPECT_TRUE(are_alike(rays));
  for (std::size_t i = 0; i < rays.size(); i += 2) rays[i].dir = {0, 0, 1};
  EXPECT_FALSE(are_alike(rays));
  EXPECT_TRUE(are_alike({}));
}

}  // namespace
}  // namespace accel
