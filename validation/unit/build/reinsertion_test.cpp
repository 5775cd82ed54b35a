// What reinsertion owes to callers: cheaper trees over the same leaves, the same for any number of threads, within the limits.
#include "libaccel/build/reinsertion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <tuple>

#include "libaccel/build/binned_sah.h"
#include "libaccel/build/coded_wide_sbvh.h"
#include "libaccel/build/instances.h"
#include "libaccel/build/kdtree_sah.h"
#include "libaccel/build/sbvh.h"
#include "libaccel/build/wide_sbvh.h"
#include "libaccel/structure/bvh2_stats.h"
#include "libaccel/structure/bvh8_stats.h"
#include "libaccel/trace/bvh2_stack.h"
#include "libaccel/trace/bvh8_ordered.h"
#include "validation/unit/build/builder_checks.h"
#include "validation/unit/build/bvh2_shapes.h"

namespace accel {
namespace {

using test::build;

constexpr int kManyRounds = 20;
const BuildOptions kWithout{.reinsertion_rounds = 0};

// A builder that others' checks take, with reinsertion.
template <class Builder>
struct Improved {
  using Structure = typename Builder::Structure;
  static Result<Built<Structure>> build(const TriangleMesh& mesh, BuildOptions options) {
    options.reinsertion_rounds = kManyRounds;
    return Builder::build(mesh, options);
  }
};

double cost_of(const Bvh2& bvh) { return bvh2_stats(bvh, 1, 1).sah_cost; }

// What the note says.
struct Told {
  int rounds = -1;
  unsigned long moves = 0;
  double before = 0, after = 0;
};
Told told_by(const BuildReport& report) {
  Told told;
  for (const BuildNote& note : report.notes)
    if (note.what == "reinsertion") {
      const char* const format = note.why.find("round:") != std::string::npos
                                     ? "optimized in %d round: %lu nodes moved, SAH cost %lf to %lf;"
                                     : "optimized in %d rounds: %lu nodes moved, SAH cost %lf to %lf;";
      EXPECT_EQ(std::sscanf(note.why.c_str(), format, &told.rounds, &told.moves, &told.before, &told.after), 4) << note.why;
    }
  return told;
}
bool says(const BuildReport& report, const std::string& words) {
  return std::any_of(report.notes.begin(), report.notes.end(),
                     [&](const BuildNote& note) { return note.why.find(words) != std::string::npos; });
}

// The meshes of all builders' tests, and what else hurts: as many nodes of the same box as there are triangles.
std::vector<test::NamedMesh> hard_meshes() {
  std::vector<test::NamedMesh> meshes = test::all_meshes();
  std::vector<Triangle> concentric, repeated;
  for (int i = 1; i <= 300; ++i) {
    const float s = 1.0f / static_cast<float>(i);
    concentric.push_back({{-s, -s, 0}, {s, -s, s}, {s, s, -s}});
    const auto at = static_cast<float>(i % 3);
    repeated.push_back({{at, 0, 0}, {at + 1, 0, 0}, {at, 1, 1}});
  }
  meshes.push_back({"concentric", test::mesh_of(concentric)});
  meshes.push_back({"repeated", test::mesh_of(repeated)});
  return meshes;
}

// A tree by itself, with the note that it gives.
std::pair<Bvh2, BuildReport> improved(const Bvh2& bvh, const TriangleMesh& mesh, const BuildOptions& options) {
  BuildContext context(mesh, options);
  Bvh2 result = bvh;
  result.nodes = Buffer<Bvh2Node>::copy_of(bvh.nodes.span());
  const Status done = reinsert(context, result);
  EXPECT_TRUE(done.ok()) << done.message();
  const Status valid = validate(result, mesh.size());
  EXPECT_TRUE(valid.ok()) << valid.message();
  return {std::move(result), context.finish()};
}

// Of each leaf the box and the triangles, in an order of their own.
auto contents(const Bvh2& bvh) {
  std::vector<std::tuple<std::vector<std::uint32_t>, std::vector<float>>> all;
  for (const test::BoxedLeaf& leaf : test::boxed_leaves(bvh)) {
    std::vector<std::uint32_t> words;
    for (std::uint32_t q = leaf_quad(leaf.ref); !is_end_of_leaf(bvh.leaves.data(), q); q += kQuadsPerTriangle)
      words.push_back(bvh.leaves[q].word);
    all.push_back({words, {leaf.box.lo.x, leaf.box.lo.y, leaf.box.lo.z, leaf.box.hi.x, leaf.box.hi.y, leaf.box.hi.z}});
  }
  std::sort(all.begin(), all.end());
  return all;
}

template <class Builder>
class ReinsertionOf : public testing::Test {};
using Bvh2Builders = testing::Types<BinnedSah, Sbvh>;
TYPED_TEST_SUITE(ReinsertionOf, Bvh2Builders);

TYPED_TEST(ReinsertionOf, CostNeverRises) {
  for (const auto& [name, mesh] : hard_meshes()) {
    SCOPED_TRACE(name);
    double last = cost_of(build<TypeParam>(mesh, kWithout).structure);
    for (const int rounds : {1, 2, 3, 5, kManyRounds}) {
      const double cost = cost_of(build<TypeParam>(mesh, {.reinsertion_rounds = rounds}).structure);
      EXPECT_LE(cost, last * (1 + 1e-12)) << rounds << " rounds";
      last = cost;
    }
  }
}

TYPED_TEST(ReinsertionOf, HitsAreThoseOfBruteForce) {
  constexpr float kHalf = 2.0f / 3.0f;
  for (const auto& [name, mesh] : hard_meshes()) {
    SCOPED_TRACE(name);
    test::expect_hits_of_brute_force<Bvh2Stack<Watertight, Query::closest>>(
        mesh, build<Improved<TypeParam>>(mesh).structure, {{-kHalf, -kHalf, -kHalf}, {kHalf, kHalf, kHalf}}, 100);
  }
}

TYPED_TEST(ReinsertionOf, LeavesKeepTheirBoxesAndTriangles) {
  for (const auto& [name, mesh] : hard_meshes()) {
    SCOPED_TRACE(name);
    const Built<Bvh2> before = build<TypeParam>(mesh, kWithout), after = build<Improved<TypeParam>>(mesh);
    EXPECT_TRUE(contents(before.structure) == contents(after.structure));
    EXPECT_EQ(before.structure.references, after.structure.references);
    test::expect_true_report(mesh, after, bvh2_stats(after.structure, 1, 1));
  }
}

TYPED_TEST(ReinsertionOf, BytesDoNotDependOnThreads) {
  test::expect_same_bytes_for_any_threads<Improved<TypeParam>>(test::soup(70000, 0.05f));
  test::expect_same_bytes_for_any_threads<Improved<TypeParam>>(test::flat_grid(190));  // many gains are equal
}

TYPED_TEST(ReinsertionOf, DepthStaysWithinItsBound) {
  for (const auto& [name, mesh] : hard_meshes())
    for (const int max_depth : {0, 1, 5, 12}) {
      SCOPED_TRACE(name + ", " + std::to_string(max_depth));
      const Bvh2 bvh = build<Improved<TypeParam>>(mesh, {.max_depth = max_depth}).structure;
      EXPECT_LE(bvh.depth, static_cast<std::uint32_t>(max_depth));
    }
}

// The first is what the second must not do.
TYPED_TEST(ReinsertionOf, AtItsBoundATreeGetsNoDeeper) {
  const TriangleMesh mesh = test::soup(3000, 0.5f);
  const auto depth = static_cast<int>(build<TypeParam>(mesh, kWithout).structure.depth);
  EXPECT_GT(static_cast<int>(build<Improved<TypeParam>>(mesh).structure.depth), depth);
  const Built<Bvh2> bound = build<Improved<TypeParam>>(mesh, {.max_depth = depth});
  EXPECT_EQ(static_cast<int>(bound.structure.depth), depth);
  EXPECT_GT(told_by(bound.report).moves, 100u);
}

TYPED_TEST(ReinsertionOf, TheReportTellsCostsRoundsAndMoves) {
  const TriangleMesh mesh = test::soup(3000, 0.5f);
  const Built<Bvh2> before = build<TypeParam>(mesh, kWithout);
  EXPECT_EQ(told_by(before.report).rounds, -1);
  for (const int rounds : {1, 2, 3}) {
    const Built<Bvh2> after = build<TypeParam>(mesh, {.reinsertion_rounds = rounds});
    const Told told = told_by(after.report);
    EXPECT_EQ(told.rounds, rounds);
    EXPECT_GT(told.moves, 0u);
    EXPECT_NEAR(told.before, cost_of(before.structure), 1e-3 * told.before);
    EXPECT_NEAR(told.after, cost_of(after.structure), 1e-3 * told.after);
    EXPECT_LT(told.after, told.before);
    EXPECT_EQ(after.report.phases.back().name, "reinsertion");
    EXPECT_TRUE(says(after.report, "no more were asked for"));
  }
}

TYPED_TEST(ReinsertionOf, RoundsEndWhenTheyGainLittle) {
  const Built<Bvh2> built = build<TypeParam>(test::soup(3000, 0.5f), {.reinsertion_rounds = kMaxReinsertionRounds});
  EXPECT_LT(told_by(built.report).rounds, 50);
  EXPECT_TRUE(says(built.report, "the last gained little"));
}

// No round, or the one that had begun before the time was up.
TYPED_TEST(ReinsertionOf, NoRoundBeginsWhenTimeIsUp) {
  const Built<Bvh2> built =
      build<TypeParam>(test::soup(3000, 0.5f), {.reinsertion_rounds = kManyRounds, .reinsertion_seconds = 1e-9f});
  EXPECT_LE(told_by(built.report).rounds, 1);
  EXPECT_TRUE(says(built.report, "time was up"));
}

TYPED_TEST(ReinsertionOf, ProgressCanInterrupt) {
  BuildOptions options;
  options.reinsertion_rounds = 1;
  options.progress = [](std::string_view phase, double) { return phase != "reinsertion"; };
  const auto built = TypeParam::build(test::soup(20000, 0.1f), options);
  ASSERT_FALSE(built.ok());
  EXPECT_EQ(built.message(), kInterrupted);
}

TYPED_TEST(ReinsertionOf, MeaninglessOptionsAreRefused) {
  const auto refuses = [](auto change) { return test::refuses<TypeParam>(change); };
  EXPECT_TRUE(refuses([](BuildOptions& o) { o.reinsertion_rounds = -1; }));
  EXPECT_TRUE(refuses([](BuildOptions& o) { o.reinsertion_rounds = kMaxReinsertionRounds + 1; }));
  EXPECT_TRUE(refuses([](BuildOptions& o) { o.reinsertion_seconds = -1; }));
  EXPECT_TRUE(refuses([](BuildOptions& o) { o.reinsertion_seconds = std::numeric_limits<float>::quiet_NaN(); }));
  EXPECT_TRUE(refuses([](BuildOptions& o) { o.reinsertion_seconds = std::numeric_limits<float>::infinity(); }));
}

TYPED_TEST(ReinsertionOf, ScalingByAPowerOfTwoKeepsTheTree) {
  const TriangleMesh mesh = test::soup(1000, 0.2f);
  TriangleMesh scaled = mesh;
  scaled.vertices = Buffer<Vec3>::copy_of(mesh.vertices.span());
  for (Vec3& v : scaled.vertices) v = v * 0x1p40f;
  const Built<Bvh2> a = build<Improved<TypeParam>>(mesh), b = build<Improved<TypeParam>>(scaled);
  ASSERT_EQ(a.structure.nodes.size(), b.structure.nodes.size());
  for (std::size_t i = 0; i < a.structure.nodes.size(); ++i)
    for (int c = 0; c < 2; ++c) EXPECT_EQ(a.structure.nodes[i].child[c], b.structure.nodes[i].child[c]);
}

// Two pairs of neighbours, each with one of the other's.
TEST(Reinsertion, NeighboursComeTogether) {
  std::vector<Triangle> triangles;
  for (const float x : {0.0f, 100.0f, 1.0f, 101.0f}) triangles.push_back({{x, 0, 0}, {x + 1, 0, 0}, {x, 1, 1}});
  const TriangleMesh mesh = test::mesh_of(triangles);
  const Bvh2 best = build<BinnedSah>(mesh, {.max_leaf_size = 1, .reinsertion_rounds = 0}).structure;
  std::vector<test::BoxedLeaf> leaves = test::boxed_leaves(best);
  std::swap(leaves[1], leaves[2]);
  const auto halves = [](std::size_t begin, std::size_t end) { return begin + (end - begin) / 2; };
  const Bvh2 worse = test::with_tree(best, leaves, halves);
  EXPECT_GT(cost_of(worse), 1.5 * cost_of(best));
  EXPECT_NEAR(cost_of(improved(worse, mesh, {.reinsertion_rounds = kManyRounds}).first), cost_of(best), 1e-9);
}

TEST(Reinsertion, RepairsTreesInRandomOrder) {
  const TriangleMesh mesh = test::soup(5000, 0.05f);
  const Bvh2 good = build<BinnedSah>(mesh, kWithout).structure, bad = test::shuffled(good);
  EXPECT_GT(cost_of(bad), 4 * cost_of(good));
  EXPECT_LT(cost_of(improved(bad, mesh, {.reinsertion_rounds = kMaxReinsertionRounds}).first), 1.1 * cost_of(good));
}

// Each triangle's box is in the next one's, so a chain is the cheapest tree. What stacks cannot hold is not made, though the
// options would allow it.
TEST(Reinsertion, TreesStayWithinStacks) {
  std::vector<Triangle> triangles;
  for (int i = 0; i < 300; ++i) {
    const float s = std::pow(1.02f, static_cast<float>(i));
    triangles.push_back({{0, 0, 0}, {s, 0, 0}, {0, s, s}});
  }
  const TriangleMesh mesh = test::mesh_of(triangles);
  const Bvh2 bad = test::shuffled(build<BinnedSah>(mesh, {.max_leaf_size = 1, .reinsertion_rounds = 0}).structure);
  const Bvh2 after = improved(bad, mesh, {.max_depth = kMaxBuildDepth, .reinsertion_rounds = kMaxReinsertionRounds}).first;
  EXPECT_LE(after.depth, static_cast<std::uint32_t>(kBvh2StackSize));
  EXPECT_GT(after.depth, 100u);
}

// Depth first, the larger child first: as build/emit_bvh2.h has it.
TEST(Reinsertion, NodesAndLeavesAreInTheOrderOfBuilders) {
  const Bvh2 bvh = build<Improved<Sbvh>>(test::slivers(2000)).structure;
  std::vector<NodeRef> pending{bvh.root};
  std::uint32_t node = 0, quad = 0;
  while (!pending.empty()) {
    const NodeRef ref = pending.back();
    pending.pop_back();
    if (is_leaf(ref)) {
      ASSERT_EQ(leaf_quad(ref), quad);
      for (; !is_end_of_leaf(bvh.leaves.data(), quad); quad += kQuadsPerTriangle) {
      }
      ++quad;
      continue;
    }
    ASSERT_EQ(ref, node++);
    EXPECT_GE(half_area_in_double(bvh.nodes[ref].bounds(0)), half_area_in_double(bvh.nodes[ref].bounds(1)));
    for (const int c : {1, 0}) pending.push_back(bvh.nodes[ref].child[c]);
  }
}

TEST(Reinsertion, PeakMemoryCountsTheBookkeeping) {
  const TriangleMesh mesh = test::soup(20000, 0.02f);
  const Built<Bvh2> built = build<Improved<BinnedSah>>(mesh);
  EXPECT_GE(built.report.peak_bytes, 2 * built.structure.size_bytes());
}

template <class Builder>
void expect_cheaper_wide_tree() {
  constexpr float kHalf = 2.0f / 3.0f;
  const TriangleMesh mesh = test::soup(3000, 0.5f);
  const auto before = build<Builder>(mesh), after = build<Improved<Builder>>(mesh);
  EXPECT_LT(bvh8_stats(after.structure, 1, 1).sah_cost, bvh8_stats(before.structure, 1, 1).sah_cost);
  EXPECT_GT(told_by(after.report).moves, 0u);
  EXPECT_EQ(after.report.references, after.structure.references);
  test::expect_hits_of_brute_force<Bvh8Ordered<Watertight, Query::closest>>(
      mesh, after.structure, {{-kHalf, -kHalf, -kHalf}, {kHalf, kHalf, kHalf}}, 100);
}
TEST(Reinsertion, WideTreesAreCollapsedFromWhatItMade) { expect_cheaper_wide_tree<WideSbvh>(); }

// Trees over meshes, and the one over the instances.
TEST(Reinsertion, TreesOfInstancesAreImproved) {
  const TriangleMesh mesh = test::soup(500, 0.5f);
  std::vector<Instance> places;
  for (std::uint32_t i = 0; i < 40; ++i) {
    CounterRng rng(3, i);
    const Vec3 at = 5 * test::random_point(rng);
    places.push_back({0, Affine{{{1, 0, 0, at.x}, {0, 1, 0, at.y}, {0, 0, 1, at.z}}}});
  }
  const auto scene = InstancedMeshes::make({mesh}, places);
  ASSERT_TRUE(scene.ok()) << scene.message();
  const auto before = InstanceBuilder::build(*scene, {}), after = InstanceBuilder::build(*scene, {.reinsertion_rounds = 5});
  ASSERT_TRUE(before.ok() && after.ok());
  EXPECT_TRUE(validate(after->structure, scene->size()).ok());
  EXPECT_FALSE(test::same_bytes(before->structure, after->structure));
}

TEST(Reinsertion, OtherBuildersIgnoreIt) {
  const TriangleMesh mesh = test::soup(2000, 0.1f);
  EXPECT_TRUE(test::same_bytes(build<KdTreeSah>(mesh).structure, build<Improved<KdTreeSah>>(mesh).structure));
}

}  // namespace
}  // namespace accel
