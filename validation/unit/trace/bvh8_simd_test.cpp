// SIMD against its scalar twin, on every target that the machine has: for every node layout, box test and triangle test.
#include "libaccel/trace/bvh8_simd.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "libaccel/build/code_bvh8.h"
#include "libaccel/build/collapse_wide.h"
#include "libaccel/build/wide_sbvh.h"
#include "libaccel/exec/drive.h"
#include "libaccel/trace/bvh8_ordered.h"
#include "validation/stress/random_bvh2.h"
#include "validation/stress/stress_rays.h"
#include "validation/stress/stress_scenes.h"
#include "validation/unit/build/test_meshes.h"
#include "validation/unit/trace/simd_batches.h"

namespace accel {
namespace {

using test::on_every_target;
using test::same;

// Targets without fused operations round twice.
bool has_fused_operations() { return std::set<std::string>{"AVX2", "AVX3", "AVX3_DL"}.count(bvh8_simd_target()) != 0; }

template <class Slabs, class Test, class Node, class Answer>
void trace_in_batches(const Bvh8ViewOf<Node>& view, std::span<const Ray> rays, std::span<Answer> answers) {
  test::trace_in_batches(Bvh8Simd<Node, Slabs, Test>::functions(), view, rays, answers);
}

// Returns how many rays hit something.
template <class Slabs, class Test, class Node>
std::size_t expect_same_as_scalar(const std::string& name, const Bvh8Of<Node>& bvh, const std::vector<Ray>& rays) {
  std::vector<Hit> expected;
  std::vector<std::uint8_t> blocked;
  std::size_t valid = 0;
  NullObserver observer;
  for (const Ray& ray : rays) {
    expected.push_back(trace_ray<Bvh8OrderedWith<Node, Slabs, Test, Query::closest>>(bvh.view(), ray, observer));
    const Hit any = trace_ray<Bvh8OrderedWith<Node, Slabs, Test, Query::any>>(bvh.view(), ray, observer);
    blocked.push_back(any.valid() ? 1 : 0);
    valid += expected.back().valid();
  }
  on_every_target([&] {
    if ((Slabs::kIsFused || std::is_same_v<Test, WoopKahan>)&&!has_fused_operations()) return;
    std::vector<Hit> hits(rays.size(), Hit{1, 2, 3, 4});
    std::vector<std::uint8_t> occluded(rays.size(), 7);
    trace_in_batches<Slabs, Test, Node, Hit>(bvh.view(), rays, hits);
    trace_in_batches<Slabs, Test, Node, std::uint8_t>(bvh.view(), rays, occluded);
    std::size_t different = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) different += same(hits[i], expected[i]) ? 0 : 1;
    EXPECT_EQ(different, 0u) << name << ' ' << bvh8_simd_target();
    EXPECT_EQ(occluded, blocked) << name << ' ' << bvh8_simd_target();
  });
  return valid;
}

std::vector<Ray> rays_for(const TriangleMesh& mesh) {
  std::vector<Ray> rays = validation::stress_rays(mesh, 600);
  for (const Ray& ray : validation::nearly_parallel_rays(mesh, -149, -20, 100)) rays.push_back(ray);
  for (const Ray& ray : validation::invalid_rays()) rays.push_back(ray);
  for (std::size_t i = 0; i < rays.size(); i += 3) rays[i].t_max = 0.5f;
  for (std::size_t i = 1; i < rays.size(); i += 5) rays[i].t_min = i % 2 == 0 ? 0.1f : -1.0f;
  return rays;
}

// On scenes that hurt. `layout` makes the structure from the one with exact boxes.
template <class Slabs, class Test, class Layout>
void expect_same_on_all_scenes(const Layout& layout) {
  std::size_t valid = 0;
  for (const auto& [name, mesh] : validation::stress_scenes()) {
    const auto built = WideSbvh::build(mesh, {});
    ASSERT_TRUE(built) << built.message();
    valid += expect_same_as_scalar<Slabs, Test>(name, layout(built->structure), rays_for(mesh));
  }
  EXPECT_GT(valid, 1000u);
}

const auto kExact = [](const Bvh8& bvh) { return bvh; };

TEST(Bvh8Simd, HitsAreThoseOfTheScalarTwin) { expect_same_on_all_scenes<PaddedSlabs, Watertight>(kExact); }

TEST(Bvh8Simd, WithOtherBoxTests) {
  expect_same_on_all_scenes<NaiveSlabs, Watertight>(kExact);
  expect_same_on_all_scenes<FusedSlabs, Watertight>(kExact);
}

TEST(Bvh8Simd, OverCodedBoxes) {
  expect_same_on_all_scenes<PaddedSlabs, Watertight>([](const Bvh8& bvh) { return code_bvh8<ByteBvh8Node>(bvh); });
  expect_same_on_all_scenes<PaddedSlabs, Watertight>([](const Bvh8& bvh) { return code_bvh8<HalfBvh8Node>(bvh); });
}

TEST(Bvh8Simd, OverBlocksThatNameVertices) {
  expect_same_on_all_scenes<PaddedSlabs, Watertight>([](const Bvh8& bvh) { return code_bvh8<CompactBvh8Node>(bvh); });
}

// The same boxes and triangles. The scalar twins agree, since each agrees with its own.
TEST(Bvh8Simd, CompactTreesHaveTheHitsOfBytes) {
  for (const validation::StressScene& scene : validation::stress_scenes()) {
    const auto built = WideSbvh::build(scene.mesh, {});
    ASSERT_TRUE(built) << built.message();
    const auto bytes = code_bvh8<ByteBvh8Node>(built->structure);
    const auto compact = code_bvh8<CompactBvh8Node>(built->structure);
    const std::vector<Ray> rays = rays_for(scene.mesh);
    on_every_target([&] {
      std::vector<Hit> expected(rays.size()), hits(rays.size());
      std::vector<std::uint8_t> blocked(rays.size()), occluded(rays.size());
      trace_in_batches<PaddedSlabs, Watertight, ByteBvh8Node, Hit>(bytes.view(), rays, expected);
      trace_in_batches<PaddedSlabs, Watertight, CompactBvh8Node, Hit>(compact.view(), rays, hits);
      trace_in_batches<PaddedSlabs, Watertight, ByteBvh8Node, std::uint8_t>(bytes.view(), rays, blocked);
      trace_in_batches<PaddedSlabs, Watertight, CompactBvh8Node, std::uint8_t>(compact.view(), rays, occluded);
      EXPECT_TRUE(std::equal(hits.begin(), hits.end(), expected.begin(), same)) << scene.name << ' ' << bvh8_simd_target();
      EXPECT_EQ(occluded, blocked) << scene.name << ' ' << bvh8_simd_target();
    });
  }
}

TEST(Bvh8Simd, WithOtherTriangleTests) {
  expect_same_on_all_scenes<PaddedSlabs, MoellerTrumbore>(kExact);
  expect_same_on_all_scenes<PaddedSlabs, Woop>(kExact);
  expect_same_on_all_scenes<PaddedSlabs, WoopKahan>(kExact);
  expect_same_on_all_scenes<PaddedSlabs, Pluecker>(kExact);
}

// Trees with long leaves, and with many levels.
TEST(Bvh8Simd, OfTreesThatNoHeuristicWouldBuild) {
  const TriangleMesh mesh = test::soup(400, 0.5f);
  for (const validation::TreeShape shape : validation::kTreeShapes)
    for (const std::uint32_t leaf_size : {1u, 100u}) {
      const Bvh2 binary = validation::random_bvh2(mesh, 5, {.shape = shape, .leaf_size = leaf_size, .max_depth = 120});
      const Bvh8 bvh = *collapse_wide(binary, {.max_leaf_size = static_cast<int>(leaf_size)});
      const auto found = expect_same_as_scalar<PaddedSlabs, Watertight>("", bvh, rays_for(mesh));
      EXPECT_GT(found, 100u);
      const auto compact = code_bvh8<CompactBvh8Node>(bvh);
      const auto found_in_compact = expect_same_as_scalar<PaddedSlabs, Watertight>("compact", compact, rays_for(mesh));
      EXPECT_EQ(found_in_compact, found);
    }
}

}  // namespace
}  // namespace accel
