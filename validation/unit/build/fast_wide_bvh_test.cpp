// What the builder owes to its callers, on every mesh: builder.h and bvh8.h.
#include "libaccel/build/fast_wide_bvh.h"

#include <gtest/gtest.h>

#include "libaccel/build/sbvh.h"
#include "libaccel/structure/bvh2_stats.h"
#include "libaccel/structure/bvh8_stats.h"
#include "libaccel/trace/bvh8_ordered.h"
#include "validation/unit/build/builder_checks.h"

namespace accel {
namespace {

using test::build;

TEST(FastWideBvhBuilder, NothingToBuildIsAnEmptyTree) {
  for (const TriangleMesh& mesh : test::empty_meshes()) {
    const Built<Bvh8> built = build<FastWideBvh>(mesh);
    EXPECT_EQ(built.structure.root, kNoNode);
    EXPECT_EQ(built.report.skipped.zero_area, mesh.size());
  }
}

TEST(FastWideBvhBuilder, OneTriangleIsALeaf) {
  const Built<Bvh8> built = build<FastWideBvh>(test::soup(1, 0.5f));
  EXPECT_TRUE(is_leaf(built.structure.root));
  EXPECT_EQ(built.structure.depth, 0u);
}

TEST(FastWideBvhBuilder, ReportAgreesWithTheTree) {
  for (const auto& [name, mesh] : test::all_meshes()) {
    SCOPED_TRACE(name);
    const Built<Bvh8> built = build<FastWideBvh>(mesh);
    const Bvh8Stats stats = bvh8_stats(built.structure, 1, 1);
    test::expect_true_report(mesh, built, stats);
    EXPECT_EQ(stats.depth, built.structure.depth);
    EXPECT_EQ(built.report.phases.back().name, "blocks");
    EXPECT_TRUE(built.structure.bounds.contains(mesh_facts(mesh).bounds));
  }
}

TEST(FastWideBvhBuilder, HitsAreThoseOfBruteForce) {
  constexpr float kHalf = 2.0f / 3.0f;
  for (const auto& [name, mesh] : test::all_meshes()) {
    SCOPED_TRACE(name);
    test::expect_hits_of_brute_force<Bvh8Ordered<Watertight, Query::closest>>(
        mesh, build<FastWideBvh>(mesh).structure, {{-kHalf, -kHalf, -kHalf}, {kHalf, kHalf, kHalf}}, 100);
  }
}

TEST(FastWideBvhBuilder, BytesDoNotDependOnThreads) {
  test::expect_same_bytes_for_any_threads<FastWideBvh>(test::soup(70000, 0.05f));
}

TEST(FastWideBvhBuilder, DepthStaysWithinItsBound) {
  for (const auto& [name, mesh] : test::all_meshes())
    for (const int max_depth : {0, 1, 5, 12}) {
      SCOPED_TRACE(name + ", " + std::to_string(max_depth));
      const Built<Bvh8> built = build<FastWideBvh>(mesh, {.max_depth = max_depth});
      EXPECT_LE(built.structure.depth, static_cast<std::uint32_t>(max_depth));
    }
}

// A wide tree has a seventh of the inner nodes, or some more, and shares no cost with the binary one that it does not need.
TEST(FastWideBvhBuilder, WideTreesAreFlatAndCheap) {
  const TriangleMesh mesh = test::soup(20000, 0.03f);
  const Bvh8Stats wide = bvh8_stats(build<FastWideBvh>(mesh).structure, 1, 1);
  const Bvh2Stats binary = bvh2_stats(build<Sbvh>(mesh).structure, 1, 1);
  EXPECT_LT(wide.inner_nodes, binary.inner_nodes / 4);
  EXPECT_LT(wide.sah_cost, 0.5 * binary.sah_cost);
  EXPECT_GT(wide.mean_children, 5.0);
  EXPECT_LT(wide.depth, binary.depth);
}

TEST(FastWideBvhBuilder, ScalingByAPowerOfTwoKeepsTheTree) {
  const TriangleMesh mesh = test::soup(1000, 0.2f);
  TriangleMesh scaled = mesh;
  scaled.vertices = Buffer<Vec3>::copy_of(mesh.vertices.span());
  for (Vec3& v : scaled.vertices) v = v * 0x1p40f;
  const Built<Bvh8> a = build<FastWideBvh>(mesh), b = build<FastWideBvh>(scaled);
  ASSERT_EQ(a.structure.nodes.size(), b.structure.nodes.size());
  for (std::size_t i = 0; i < a.structure.nodes.size(); ++i)
    for (std::uint32_t c = 0; c < kBvh8Arity; ++c) {
      EXPECT_EQ(a.structure.nodes[i].child[c], b.structure.nodes[i].child[c]);
      EXPECT_EQ(a.structure.nodes[i].order[c], b.structure.nodes[i].order[c]);
    }
}

TEST(FastWideBvhBuilder, ProgressCanInterrupt) { test::expect_progress_interrupts<FastWideBvh>(); }

TEST(FastWideBvhBuilder, MeaninglessOptionsAreRefused) {
  EXPECT_TRUE(test::refuses<FastWideBvh>([](BuildOptions& o) { o.threads = -1; }));
  EXPECT_TRUE(test::refuses<FastWideBvh>([](BuildOptions& o) { o.max_leaf_size = 0; }));
}

}  // namespace
}  // namespace accel
