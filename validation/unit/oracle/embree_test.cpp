// Embree by packets and streams against Embree ray by ray.
#include "validation/oracle/embree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <vector>

#include "libaccel/rays/ray_sets.h"
#include "scenes/procedural.h"
#include "validation/stress/stress_rays.h"
#include "validation/stress/stress_scenes.h"

namespace accel::validation {
namespace {

constexpr EmbreeCalls kCalls[] = {EmbreeCalls::single, EmbreeCalls::packets8, EmbreeCalls::packets16, EmbreeCalls::streams};
constexpr const char* kCallNames[] = {"single", "packets8", "packets16", "streams"};

TriangleMesh scene_mesh() { return *make_builtin("stadium:3000")->one_mesh(); }

std::vector<Ray> random_batch(const TriangleMesh& mesh, std::size_t count) {
  if (count == 0) return {};
  Aabb bounds;
  for (const Vec3& v : mesh.vertices) bounds.extend(v);
  const auto set = random_rays(bounds, count, 11);
  return {set->rays.begin(), set->rays.end()};
}

// Calls, and the mode and quality of the scene.
class EmbreeCallsTest : public testing::TestWithParam<std::tuple<EmbreeCalls, EmbreeMode, EmbreeQuality>> {
 protected:
  void SetUp() override {
    if (!EmbreeWitness::available()) GTEST_SKIP() << EmbreeWitness::version();
  }

  EmbreeCalls calls() const { return std::get<0>(GetParam()); }
  Result<EmbreeWitness> build(const TriangleMesh& mesh) const {
    return EmbreeWitness::build(mesh, {std::get<1>(GetParam()), std::get<2>(GetParam()), 1});
  }

  // The answers start out as what no query gives.
  std::vector<Hit> closest(const EmbreeWitness& embree, const std::vector<Ray>& rays, int threads = 1) const {
    std::vector<Hit> hits(rays.size(), Hit{-1, -1, -1, 12345678});
    const Result<double> seconds = embree.time_closest(calls(), rays, hits, threads);
    EXPECT_TRUE(seconds && *seconds >= 0);
    return hits;
  }
  std::vector<std::uint8_t> occluded(const EmbreeWitness& embree, const std::vector<Ray>& rays, int threads = 1) const {
    std::vector<std::uint8_t> flags(rays.size(), 7);
    const Result<double> seconds = embree.time_occluded(calls(), rays, flags, threads);
    EXPECT_TRUE(seconds && *seconds >= 0);
    return flags;
  }

  // The same triangles; Embree's ways may round t, u and v differently.
  void expect_as_single(const EmbreeWitness& embree, const std::vector<Ray>& rays) const {
    std::vector<Hit> expected(rays.size());
    std::vector<std::uint8_t> expected_any(rays.size());
    embree.closest(rays, expected, 1);
    embree.occluded(rays, expected_any, 1);
    const std::vector<Hit> hits = closest(embree, rays);
    EXPECT_EQ(occluded(embree, rays), expected_any);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      EXPECT_EQ(hits[i].prim_id, expected[i].prim_id) << i;
      if (!expected[i].valid()) continue;
      EXPECT_NEAR(hits[i].t, expected[i].t, 1e-4f * (1 + std::abs(expected[i].t))) << i;
      EXPECT_NEAR(hits[i].u, expected[i].u, 1e-3f) << i;
      EXPECT_NEAR(hits[i].v, expected[i].v, 1e-3f) << i;
    }
  }
};

TEST_P(EmbreeCallsTest, BatchesOfAnySizeAnswerAsSingleRaysDo) {
  const TriangleMesh mesh = scene_mesh();
  const auto embree = build(mesh);
  ASSERT_TRUE(embree) << embree.message();
  if (const Status possible = embree->can(calls()); !possible) GTEST_SKIP() << possible.message();
  for (const std::size_t size : {0, 1, 7, 8, 9, 15, 16, 17, 33, 1023, 1024, 1025, 20000}) {
    SCOPED_TRACE(size);
    expect_as_single(*embree, random_batch(mesh, size));
  }
}

TEST_P(EmbreeCallsTest, NumberOfThreadsChangesNoAnswer) {
  const TriangleMesh mesh = scene_mesh();
  const auto embree = build(mesh);
  ASSERT_TRUE(embree) << embree.message();
  if (const Status possible = embree->can(calls()); !possible) GTEST_SKIP() << possible.message();
  const std::vector<Ray> rays = random_batch(mesh, 30000);
  const std::vector<Hit> one = closest(*embree, rays, 1), two = closest(*embree, rays, 2);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    ASSERT_EQ(one[i].prim_id, two[i].prim_id) << i;
    ASSERT_EQ(one[i].t, two[i].t) << i;
  }
  EXPECT_EQ(occluded(*embree, rays, 1), occluded(*embree, rays, 2));
}

// Embree's live assertions would end the program.
TEST_P(EmbreeCallsTest, RaysThatEmbreeMustNotSeeMissAndHarmNoNeighbour) {
  const TriangleMesh mesh = scene_mesh();
  const auto embree = build(mesh);
  ASSERT_TRUE(embree) << embree.message();
  if (const Status possible = embree->can(calls()); !possible) GTEST_SKIP() << possible.message();
  const std::vector<Ray> good = random_batch(mesh, 3000);
  std::vector<Ray> rays = good;
  const std::vector<Ray> bad = invalid_rays();
  for (std::size_t i = 0; i < rays.size(); i += 5) rays[i] = bad[i / 5 % bad.size()];
  for (std::size_t i = 512; i < 2100; ++i) rays[i] = bad[i % bad.size()];  // packets and a stream of nothing else
  expect_as_single(*embree, rays);
  const std::vector<Hit> hits = closest(*embree, rays);
  const std::vector<std::uint8_t> any = occluded(*embree, rays);
  for (std::size_t i = 0; i < rays.size(); i += 5) {
    EXPECT_FALSE(hits[i].valid()) << i;
    EXPECT_EQ(any[i], 0) << i;
  }
}

// The first triangle of an instance behind others has not number 0.
TEST_P(EmbreeCallsTest, NamesTrianglesOfInstances) {
  const Result<SceneData> scene = make_builtin("forest:20000");
  ASSERT_TRUE(scene && scene->instances);
  const auto embree = EmbreeWitness::build(*scene->instances, {std::get<1>(GetParam()), std::get<2>(GetParam()), 1});
  ASSERT_TRUE(embree) << embree.message();
  if (const Status possible = embree->can(calls()); !possible) GTEST_SKIP() << possible.message();
  const auto mesh = scene->one_mesh();
  ASSERT_TRUE(mesh) << mesh.message();
  expect_as_single(*embree, random_batch(*mesh, 5000));
}

TEST(EmbreeWitness, InstancesThatMoveAreThereAndNoLongerHere) {
  if (!EmbreeWitness::available()) GTEST_SKIP();
  const TriangleMesh mesh = mesh_of(random_triangles(50, 0.5f, 1));
  const std::vector<Instance> there = {{0, placed_by({1, 1, 1}, {0, 0, 1}, 0, {40, 0, 0})}};
  const InstancedMeshes scene = *InstancedMeshes::make({mesh}, {{0, {}}});
  auto embree = EmbreeWitness::build(scene);
  const auto built = EmbreeWitness::build(*scene.with_instances(there));
  ASSERT_TRUE(embree && built);
  ASSERT_TRUE(embree->move_instances(there));
  std::vector<Ray> rays = random_batch(mesh, 200);
  std::vector<Hit> here(200), moved(200), expected(200);
  embree->closest(rays, here);
  for (Ray& ray : rays) ray.org.x += 40;
  embree->closest(rays, moved), built->closest(rays, expected);
  EXPECT_TRUE(std::any_of(moved.begin(), moved.end(), [](const Hit& hit) { return hit.valid(); }));
  for (std::size_t i = 0; i < rays.size(); ++i) {
    EXPECT_EQ(moved[i].prim_id, expected[i].prim_id);
    EXPECT_EQ(moved[i].t, expected[i].t);
    EXPECT_FALSE(here[i].valid() && here[i].t < 20);
  }
  EXPECT_FALSE(embree->move_instances({}));
}

// Rays in range of the world that a small instance's map takes out of it: Embree's assertions again.
TEST_P(EmbreeCallsTest, RaysThatLeaveTheRangeInAnInstanceMiss) {
  const TriangleMesh mesh = scene_mesh();
  Affine tiny;
  for (int a = 0; a < 3; ++a) tiny.m[a][a] = 0x1p-30f;
  const auto scene = InstancedMeshes::make({mesh}, {{0, {}}, {0, tiny}});
  ASSERT_TRUE(scene) << scene.message();
  const auto embree = EmbreeWitness::build(*scene, {std::get<1>(GetParam()), std::get<2>(GetParam()), 1});
  ASSERT_TRUE(embree) << embree.message();
  if (const Status possible = embree->can(calls()); !possible) GTEST_SKIP() << possible.message();
  std::vector<Ray> rays = random_batch(mesh, 200);
  for (std::size_t i = 0; i < rays.size(); i += 2) rays[i].dir = rays[i].dir * 0x1p50f;
  for (std::size_t i = 0; i < rays.size(); i += 3) rays[i].org = rays[i].org * 0x1p55f;
  expect_as_single(*embree, rays);
  const std::vector<Hit> hits = closest(*embree, rays);
  EXPECT_TRUE(std::any_of(hits.begin(), hits.end(), [](const Hit& hit) { return hit.valid(); })) << "of those that stay";
  EXPECT_FALSE(hits[0].valid());
}

std::string name_of(const testing::TestParamInfo<EmbreeCallsTest::ParamType>& info) {
  const auto [calls, mode, quality] = info.param;
  return std::string(kCallNames[static_cast<int>(calls)]) + (mode == EmbreeMode::robust ? "_robust" : "_fast") +
         (quality == EmbreeQuality::high ? "_high" : "_medium");
}

INSTANTIATE_TEST_SUITE_P(All, EmbreeCallsTest,
                         testing::Combine(testing::ValuesIn(kCalls), testing::Values(EmbreeMode::fast, EmbreeMode::robust),
                                          testing::Values(EmbreeQuality::medium, EmbreeQuality::high)),
                         name_of);

}  // namespace
}  // namespace accel::validation
