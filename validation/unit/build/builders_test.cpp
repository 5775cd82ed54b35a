// What every builder of a Bvh2 owes to its callers, on every mesh: builder.h and bvh2.h.
#include "libaccel/build/builder.h"

#include <gtest/gtest.h>

#include <set>

#include "libaccel/build/binned_sah.h"
#include "libaccel/build/sbvh.h"
#include "libaccel/structure/bvh2_stats.h"
#include "libaccel/trace/bvh2_stack.h"
#include "validation/unit/build/builder_checks.h"

namespace accel {
namespace {

using test::build;
using test::same_bytes;

// The triangles of all leaves whose boxes, and all boxes above, contain the point.
std::set<std::uint32_t> triangles_around(const Bvh2& bvh, Vec3 p) {
  std::set<std::uint32_t> found;
  std::vector<NodeRef> pending{bvh.root};
  while (!pending.empty()) {
    const NodeRef ref = pending.back();
    pending.pop_back();
    if (is_leaf(ref)) {
      for (std::uint32_t q = leaf_quad(ref); !is_end_of_leaf(bvh.leaves.data(), q); q += kQuadsPerTriangle)
        found.insert(bvh.leaves[q].word);
      continue;
    }
    for (int c = 0; c < 2; ++c)
      if (bvh.nodes[ref].bounds(c).contains(Aabb{p, p})) pending.push_back(bvh.nodes[ref].child[c]);
  }
  return found;
}

template <class Builder>
class Builders : public testing::Test {};
using Bvh2Builders = testing::Types<BinnedSah, Sbvh>;
TYPED_TEST_SUITE(Builders, Bvh2Builders);

TYPED_TEST(Builders, NothingToBuildIsAnEmptyTree) {
  for (const TriangleMesh& mesh : test::empty_meshes()) {
    const Built<Bvh2> built = build<TypeParam>(mesh);
    EXPECT_EQ(built.structure.root, kNoNode);
    EXPECT_EQ(built.report.skipped.zero_area, mesh.size());
  }
}

TYPED_TEST(Builders, OneTriangleIsALeaf) {
  const Built<Bvh2> built = build<TypeParam>(test::soup(1, 0.5f));
  EXPECT_TRUE(is_leaf(built.structure.root));
  EXPECT_EQ(built.structure.depth, 0u);
}

TYPED_TEST(Builders, ReportAgreesWithTheTree) {
  for (const auto& [name, mesh] : test::all_meshes()) {
    SCOPED_TRACE(name);
    const Built<Bvh2> built = build<TypeParam>(mesh);
    const Bvh2Stats stats = bvh2_stats(built.structure, 1, 1);
    test::expect_true_report(mesh, built, stats);
    EXPECT_EQ(stats.depth, built.structure.depth);
    EXPECT_TRUE(built.structure.bounds.contains(mesh_facts(mesh).bounds));
  }
}

TYPED_TEST(Builders, BoxesContainVerticesOfTheirTriangles) {
  for (const auto& [name, mesh] : test::all_meshes()) {
    SCOPED_TRACE(name);
    const Built<Bvh2> built = build<TypeParam>(mesh);
    for (std::uint32_t i = 0; i < mesh.size(); i += 7) {
      const Triangle t = mesh.triangle(i);
      if (!is_in_range(t) || is_zero_area(t)) continue;
      for (const Vec3 v : {t.v0, t.v1, t.v2}) EXPECT_TRUE(triangles_around(built.structure, v).contains(i)) << "triangle " << i;
    }
  }
}

// Integer coordinates on planes through the origin make midpoints exact, so that inner points can be asked for without
// tolerance.
TYPED_TEST(Builders, BoxesContainInnerPointsOfTheirTriangles) {
  std::vector<Triangle> triangles;
  for (std::uint32_t i = 0; i < 600; ++i) {
    CounterRng rng(11, i);
    const auto point = [&] {
      const auto c = [&] { return 1024.0f * static_cast<float>(rng.next_below(64)); };
      const float x = c(), y = c(), z = c();
      return Vec3{x, y, z};
    };
    triangles.push_back({point(), point(), point()});
  }
  const TriangleMesh mesh = test::mesh_of(triangles);
  BuildOptions options;
  options.max_duplication = 4.0f;
  const Built<Bvh2> built = build<TypeParam>(mesh, options);
  for (std::uint32_t i = 0; i < mesh.size(); ++i) {
    if (is_zero_area(triangles[i])) continue;
    CounterRng rng(12, i);
    for (int k = 0; k < 20; ++k) {
      const auto a = static_cast<float>(rng.next_below(1025)),
                 b = static_cast<float>(rng.next_below(1025 - static_cast<std::uint32_t>(a)));
      const Vec3 p = (triangles[i].v0 * ((1024 - a - b) / 1024)) + triangles[i].v1 * (a / 1024) + triangles[i].v2 * (b / 1024);
      EXPECT_TRUE(triangles_around(built.structure, p).contains(i)) << "triangle " << i;
    }
  }
}

TYPED_TEST(Builders, HitsAreThoseOfBruteForce) {
  constexpr float kHalf = 2.0f / 3.0f;
  for (const auto& [name, mesh] : test::all_meshes()) {
    SCOPED_TRACE(name);
    test::expect_hits_of_brute_force<Bvh2Stack<Watertight, Query::closest>>(
        mesh, build<TypeParam>(mesh).structure, {{-kHalf, -kHalf, -kHalf}, {kHalf, kHalf, kHalf}}, 100);
  }
}

TYPED_TEST(Builders, BytesDoNotDependOnThreads) {
  test::expect_same_bytes_for_any_threads<TypeParam>(test::soup(70000, 0.05f));
}

TYPED_TEST(Builders, DepthStaysWithinItsBound) {
  for (const auto& [name, mesh] : test::all_meshes())
    for (const int max_depth : {0, 1, 5, 12}) {
      SCOPED_TRACE(name + ", " + std::to_string(max_depth));
      BuildOptions options;
      options.max_depth = max_depth;
      const Built<Bvh2> built = build<TypeParam>(mesh, options);
      EXPECT_LE(built.structure.depth, static_cast<std::uint32_t>(max_depth));
      // Where the levels suffice, leaves keep to their size.
      const Bvh2Stats stats = bvh2_stats(built.structure, 1, 1);
      if (built.report.triangles <= (8u << max_depth)) {
        EXPECT_LE(stats.leaves_by_size.size(), 9u);
      }
    }
}

TYPED_TEST(Builders, IdenticalTrianglesMakeABalancedTree) {
  const Built<Bvh2> built = build<TypeParam>(test::identical(100000));
  EXPECT_LE(built.structure.depth, 17u);
  EXPECT_EQ(built.structure.references, 100000u);
}

TYPED_TEST(Builders, ReferencesStayWithinTheBudget) {
  for (const float duplication : {0.0f, 0.1f, 0.5f, 2.0f}) {
    BuildOptions options;
    options.max_duplication = duplication;
    const Built<Bvh2> built = build<TypeParam>(test::slivers(3000), options);
    EXPECT_LE(static_cast<double>(built.report.references), (1.0 + duplication) * 3000);
  }
}

// What was left out is no room for others.
TYPED_TEST(Builders, TrianglesThatAreLeftOutAddNothingToTheBudget) {
  TriangleMesh mesh = test::slivers(3000);
  for (std::size_t i = 0; i < 1000; ++i) mesh.vertices[3 * i] = mesh.vertices[3 * i + 1];
  for (const float duplication : {0.0f, 0.1f}) {
    const Built<Bvh2> built = build<TypeParam>(mesh, {.max_duplication = duplication});
    EXPECT_EQ(built.report.triangles, 2000u);
    EXPECT_LE(static_cast<double>(built.report.references), (1.0 + duplication) * 2000);
  }
}

TYPED_TEST(Builders, LeavesAreSortedByPrimId) {
  const Built<Bvh2> built = build<TypeParam>(test::soup(2000, 0.1f));
  std::uint32_t last = 0;
  for (std::size_t q = 0; q < built.structure.leaves.size();) {
    const std::uint32_t word = built.structure.leaves[q].word;
    EXPECT_GE(word, last);
    last = word == kEndOfLeaf ? 0 : word + 1;
    q += word == kEndOfLeaf ? 1 : kQuadsPerTriangle;
  }
}

TYPED_TEST(Builders, ScalingByAPowerOfTwoKeepsTheTree) {
  const TriangleMesh mesh = test::soup(1000, 0.2f);
  TriangleMesh scaled = mesh;
  scaled.vertices = Buffer<Vec3>::copy_of(mesh.vertices.span());
  for (Vec3& v : scaled.vertices) v = v * 0x1p40f;
  const Built<Bvh2> a = build<TypeParam>(mesh), b = build<TypeParam>(scaled);
  ASSERT_EQ(a.structure.nodes.size(), b.structure.nodes.size());
  for (std::size_t i = 0; i < a.structure.nodes.size(); ++i)
    for (int c = 0; c < 2; ++c) EXPECT_EQ(a.structure.nodes[i].child[c], b.structure.nodes[i].child[c]);
}

TYPED_TEST(Builders, ProgressCanInterrupt) { test::expect_progress_interrupts<TypeParam>(); }

TYPED_TEST(Builders, MeaninglessOptionsAreRefused) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const auto refuses = [](auto change) { return test::refuses<TypeParam>(change); };
  EXPECT_TRUE(refuses([](BuildOptions& o) { o.threads = -1; }));
  EXPECT_TRUE(refuses([](BuildOptions& o) { o.bins = 1; }));
  EXPECT_TRUE(refuses([](BuildOptions& o) { o.bins = 100000; }));
  EXPECT_TRUE(refuses([](BuildOptions& o) { o.max_leaf_size = 0; }));
  EXPECT_TRUE(refuses([](BuildOptions& o) { o.max_depth = -1; }));
  EXPECT_TRUE(refuses([&](BuildOptions& o) { o.traversal_cost = nan; }));
  EXPECT_TRUE(refuses([&](BuildOptions& o) { o.intersection_cost = -1; }));
  EXPECT_TRUE(refuses([&](BuildOptions& o) { o.max_duplication = nan; }));
  EXPECT_TRUE(refuses([&](BuildOptions& o) { o.spatial_overlap = nan; }));
}

// A few large triangles among many small ones: what spatial splits were invented for.
TEST(SbvhBuilder, SpatialSplitsLowerCostAndOverlap) {
  const TriangleMesh small = test::soup(3000, 0.02f), large = test::soup(100, 1.0f, 9);
  std::vector<Triangle> triangles;
  for (std::size_t i = 0; i < small.size(); ++i) triangles.push_back(small.triangle(i));
  for (std::size_t i = 0; i < large.size(); ++i) triangles.push_back(large.triangle(i));
  const TriangleMesh mesh = test::mesh_of(triangles);
  const BuildOptions splits_alone{.reinsertion_rounds = 0};  // which lowers both costs, that without spatial splits more
  const Bvh2 bvh = build<BinnedSah>(mesh, splits_alone).structure, sbvh = build<Sbvh>(mesh, splits_alone).structure;
  EXPECT_LT(bvh2_stats(sbvh, 1, 1).sah_cost, 0.8 * bvh2_stats(bvh, 1, 1).sah_cost);
  EXPECT_LT(end_point_overlap(sbvh, 1, 1), 0.2 * end_point_overlap(bvh, 1, 1));
}

TEST(SbvhBuilder, MoreBudgetMakesCheaperTrees) {
  double last = std::numeric_limits<double>::infinity();
  for (const float duplication : {0.0f, 0.5f, 2.0f, 8.0f}) {
    BuildOptions options;
    options.max_duplication = duplication;
    const double cost = bvh2_stats(build<Sbvh>(test::slivers(2000), options).structure, 1, 1).sah_cost;
    EXPECT_LT(cost, last);
    last = cost;
  }
}

TEST(SbvhBuilder, WithoutABudgetItIsTheObjectSplitTree) {
  BuildOptions options;
  options.max_duplication = 0;
  const TriangleMesh mesh = test::soup(2000, 0.3f);
  EXPECT_TRUE(same_bytes(build<BinnedSah>(mesh, options).structure, build<Sbvh>(mesh, options).structure));
}

}  // namespace
}  // namespace accel
