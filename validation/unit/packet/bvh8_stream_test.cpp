#include "libaccel/packet/bvh8_stream.h"

#include <gtest/gtest.h>

#include <cstring>

#include "libaccel/build/wide_sbvh.h"
#include "libaccel/exec/cpu.h"
#include "libaccel/geometry/mesh_facts.h"
#include "libaccel/geometry/woop.h"
#include "validation/stress/stress_instances.h"
#include "validation/unit/build/built_instances.h"
#include "validation/unit/build/test_meshes.h"
#include "validation/unit/packet/packets_of_rays.h"

namespace accel {
namespace {

// Streams of a tree over triangles, and of one over instances.
template <class Test, Query kQuery>
Bvh8Stream<Test, kQuery> stream_of(const Bvh8View&);
template <class Test, Query kQuery>
Bvh8InstancesStream<Test, kQuery> stream_of(const TwoLevelBvh8View&);

template <class Test, class View>
void expect_single_rays_answers(const std::string& name, const View& view, std::span<const Ray> rays,
                                const BatchSettings& settings) {
  using Closest = decltype(stream_of<Test, Query::closest>(view));
  using Any = decltype(stream_of<Test, Query::any>(view));
  std::vector<Hit> hits(rays.size(), Hit{1, 2, 3, 4}), expected(rays.size());
  std::vector<std::uint8_t> occluded(rays.size(), 7), blocked(rays.size());
  NullObserver observer;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    expected[i] = trace_ray<Closest>(view, rays[i], observer);  // its steps are those of single rays
    blocked[i] = expected[i].valid() ? 1 : 0;
  }
  trace_closest<Closest>(view, rays, hits, settings);
  trace_any<Any>(view, rays, occluded, settings);
  EXPECT_TRUE(rays.empty() || std::memcmp(hits.data(), expected.data(), hits.size() * sizeof(Hit)) == 0) << name;
  EXPECT_EQ(occluded, blocked) << name;
}

const PacketOptions kAllOptions[] = {{},
                                     {.max_size = 1, .min_size = 1},
                                     {.max_size = 100000, .block_size = 1000},
                                     {.max_size = 33, .min_size = 1, .block_size = 257},
                                     {.min_size = 1000000},
                                     {.max_size = 0, .block_size = 1}};

TEST(Bvh8Stream, HitsAreThoseOfSingleRaysWhateverThePackets) {
  for (const auto& [name, mesh] : validation::stress_scenes()) {
    const Bvh8 tree = WideSbvh::build(mesh, {})->structure;
    const std::vector<Ray> rays = test::mixed_rays(mesh, tree.bounds);
    ASSERT_TRUE(are_alike(std::span(rays).first(2000)));
    for (const PacketOptions& options : kAllOptions)
      expect_single_rays_answers<Watertight>(name, tree.view(), rays, {2, options});
    for (const std::size_t few : {0, 1, 7, 255})
      expect_single_rays_answers<Watertight>(name, tree.view(), std::span(rays).first(few), 1);
  }
}

TEST(Bvh8Stream, InInstancesWhateverThePackets) {
  for (const auto& [name, scene] : validation::instanced_scenes(9)) {
    const TwoLevelBvh8 levels = test::built<WideInstances>(scene);
    const auto in_world = scene.flattened();
    ASSERT_TRUE(in_world) << in_world.message();
    const std::vector<Ray> rays = test::mixed_rays(*in_world, mesh_facts(*in_world).bounds);
    for (const PacketOptions& options : kAllOptions)
      expect_single_rays_answers<Watertight>(name, levels.view(), rays, {2, options});
    for (const std::size_t few : {0, 1, 7, 255})
      expect_single_rays_answers<Watertight>(name, levels.view(), std::span(rays).first(few), 1);
  }
}

// Blocks that are large enough for trials: rays go all ways.
template <class View>
void expect_single_rays_answers_in_trials(const std::string& name, const View& view, const Aabb& bounds) {
  const auto camera = Camera::make(default_camera(bounds), 160, 120);
  ASSERT_TRUE(camera) << camera.message();
  const auto primary = primary_rays(*camera);
  ASSERT_TRUE(are_alike(primary->rays.span()));
  for (const std::uint32_t block_size : {32768u, 7000u})
    for (const int threads : {1, 2})
      expect_single_rays_answers<Watertight>(name, view, primary->rays.span(), {threads, {.block_size = block_size}});
}
TEST(Bvh8Stream, HitsAreThoseOfSingleRaysInTrials) {
  const Bvh8 tree = WideSbvh::build(test::soup(2000, 0.1f), {})->structure;
  expect_single_rays_answers_in_trials("soup", tree.view(), tree.bounds);
}
TEST(Bvh8Stream, InInstancesInTrials) {
  const auto scene = validation::instanced_scenes(9)[7].scene;
  const TwoLevelBvh8 levels = test::built<WideInstances>(scene);
  expect_single_rays_answers_in_trials("instances", levels.view(), levels.trees[0].bounds);
}

// Rays whose directions in an instance's space have components below those of normal numbers go by turns there.
TEST(Bvh8Stream, InInstancesWhereRaysTakeNoPartInPackets) {
  Affine stretched;
  stretched.m[2][2] = 1e18f;
  const auto scene =
      InstancedMeshes::make({test::soup(200, 0.3f)}, {Instance{}, Instance{0, stretched}, Instance{0, stretched}});
  ASSERT_TRUE(scene) << scene.message();
  const TwoLevelBvh8 levels = test::built<WideInstances>(*scene);
  std::vector<Ray> rays;
  for (int i = 0; i < 600; ++i) {
    const float y = 0.001f * static_cast<float>(i % 30), z = 0.03f * static_cast<float>(i / 30);
    rays.push_back({.org = {-1, y, i % 2 == 0 ? z * 1e18f : z}, .dir = {1, 0.5f - y, 1e-22f}});
  }
  ASSERT_LT(face_of(rays[0]), kNoFace);
  std::size_t without_face = 0;
  for (const Bvh8Instance& instance : levels.instances)
    without_face += face_of(instance.to_object.ray(rays[0])) == kNoFace ? 1 : 0;
  ASSERT_EQ(without_face, 2u);
  expect_single_rays_answers<Watertight>("stretched", levels.view(), rays, 1);
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
