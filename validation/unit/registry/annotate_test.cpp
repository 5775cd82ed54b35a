#include "libaccel/registry/annotate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "libaccel/registry/method.h"
#include "libaccel/structure/bvh2.h"
#include "libaccel/trace/bvh2_hash.h"
#include "libaccel/trace/bvh2_sibling.h"
#include "libaccel/trace/bvh2_stack.h"
#include "libaccel/trace/kdtree_backtrack.h"
#include "libaccel/trace/kdtree_restart.h"
#include "libaccel/trace/kdtree_ropes.h"
#include "validation/stress/random_bvh2.h"
#include "validation/stress/random_kdtrees.h"
#include "validation/stress/stress_scenes.h"

namespace accel {
namespace {

using Restart = KdTreeRestart<Watertight, Query::closest>;
using Backtrack = KdTreeBacktrack<Watertight, Query::closest>;
using Ropes = KdTreeRopes<Watertight, Query::closest>;

KdTree tree() { return validation::random_kdtree(validation::mesh_of(validation::random_triangles(50, 0.3f, 1)), 2); }

// The reason that the report gives; empty if there is not exactly one.
std::string why(const BuildReport& report, const std::string& what) {
  const auto is_it = [&](const BuildNote& note) { return note.what == what; };
  if (std::count_if(report.notes.begin(), report.notes.end(), is_it) != 1) return {};
  return std::find_if(report.notes.begin(), report.notes.end(), is_it)->why;
}

TEST(Annotate, AddsWhatTheTraverserReadsAndNothingElse) {
  KdTree kd = tree();
  BuildReport report;
  EXPECT_TRUE(lacks_extras<Backtrack>(kd));
  ASSERT_TRUE(annotate<Backtrack>(kd, "kdtree/backtrack", 1, report));
  EXPECT_FALSE(lacks_extras<Backtrack>(kd));
  EXPECT_FALSE(kd.parents.empty());
  EXPECT_FALSE(kd.cells.empty());
  EXPECT_TRUE(kd.ropes.empty());
  EXPECT_EQ(why(report, "parents and boxes"), "added, because kdtree/backtrack reads them");
  EXPECT_EQ(why(report, "ropes"), "skipped, because kdtree/backtrack does not read them");
  ASSERT_EQ(report.phases.size(), 1u);
  EXPECT_EQ(report.phases[0].name, "parents and boxes");
  EXPECT_EQ(report.seconds, report.phases[0].seconds);
  EXPECT_GE(report.peak_bytes, kd.size_bytes());
}

TEST(Annotate, AddsNothingForRestart) {
  KdTree kd = tree();
  BuildReport report;
  const std::size_t bytes = kd.size_bytes();
  EXPECT_FALSE(lacks_extras<Restart>(kd));
  ASSERT_TRUE(annotate<Restart>(kd, "kdtree/restart", 1, report));
  EXPECT_EQ(kd.size_bytes(), bytes);
  EXPECT_TRUE(report.phases.empty());
  EXPECT_EQ(report.notes.size(), 3u);
  EXPECT_EQ(why(report, "mailbox"), kNoMailbox.why);
}

// As when a structure is bound to one method after the other.
TEST(Annotate, KeepsWhatIsThere) {
  KdTree kd = tree();
  BuildReport report;
  ASSERT_TRUE(annotate<Backtrack>(kd, "kdtree/backtrack", 1, report));
  const KdTree before = kd;
  ASSERT_TRUE(annotate<Ropes>(kd, "kdtree/ropes", 1, report));
  EXPECT_EQ(kd.nodes.data(), before.nodes.data()) << "arrays are shared";
  EXPECT_EQ(kd.cells.data(), before.cells.data());
  EXPECT_TRUE(before.ropes.empty()) << "the copy stays as it was";
  EXPECT_EQ(report.notes.size(), 3u);
  EXPECT_EQ(why(report, "ropes"), "added, because kdtree/ropes reads them");
  EXPECT_EQ(report.phases.size(), 2u);
  ASSERT_TRUE(annotate<Ropes>(kd, "kdtree/ropes", 1, report));
  EXPECT_EQ(report.phases.size(), 2u) << "nothing is made twice";
}

TEST(Annotate, AnEmptySceneLacksNothing) {
  KdTree empty;
  BuildReport report;
  ASSERT_TRUE(annotate<Ropes>(empty, "kdtree/ropes", 1, report));
  EXPECT_TRUE(report.phases.empty());
}

TEST(Annotate, StructuresWithoutOptionalArraysStayAsTheyAre) {
  using Stack = Bvh2Stack<Watertight, Query::closest>;
  Bvh2 bvh;
  BuildReport report;
  EXPECT_FALSE(lacks_extras<Stack>(bvh));
  ASSERT_TRUE(annotate<Stack>(bvh, "bvh/stack", 1, report));
  EXPECT_TRUE(report.notes.empty());
}

// A method may need several; links of nodes exclude each other, and the structure says what it has lost.
TEST(Annotate, LinksThatExcludeEachOther) {
  using Hash = Bvh2Hash<Watertight, Query::closest>;
  using Sibling = Bvh2Sibling<Watertight, Query::closest>;
  const Bvh2 plain = validation::random_bvh2(validation::mesh_of(validation::random_triangles(90, 0.3f, 1)), 2);
  Bvh2 bvh = plain;
  BuildReport report;
  ASSERT_TRUE(annotate<Hash>(bvh, "sbvh/hash", 1, report));
  EXPECT_TRUE(bvh.has(Bvh2Extras::uncles) && bvh.has(Bvh2Extras::hash));
  EXPECT_EQ(why(report, "uncles"), "added, because sbvh/hash reads them");
  EXPECT_NE(why(report, "hash tables"), "");
  const Bvh2 hashed = bvh;
  ASSERT_TRUE(annotate<Sibling>(bvh, "sbvh/sibling", 1, report));
  EXPECT_TRUE(lacks_extras<Hash>(bvh));
  EXPECT_FALSE(lacks_extras<Hash>(hashed)) << "who shares the arrays keeps them";
  EXPECT_EQ(why(report, "uncles"), "skipped, because sbvh/sibling does not read them");
  EXPECT_EQ(bvh.slots.data(), hashed.slots.data()) << "tables do not depend on links";
}

// A builder of kd-trees for this test.
struct RandomBuilder {
  static constexpr const char* kName = "random";
  using Structure = KdTree;
  static Result<Built<KdTree>> build(const TriangleMesh& mesh, const BuildOptions&) {
    return Built<KdTree>{validation::random_kdtree(mesh, 3), {}};
  }
};

TEST(Annotate, BuildForAMethodIncludesItsArrays) {
  const TriangleMesh mesh = validation::mesh_of(validation::random_triangles(50, 0.3f, 1));
  const auto with_ropes = build_for<Method<RandomBuilder, KdTreeRopes>>(mesh, {.threads = 2});
  ASSERT_TRUE(with_ropes);
  EXPECT_TRUE(with_ropes->structure.has(KdExtras::ropes));
  const auto plain = build_for<Method<RandomBuilder, KdTreeRestart>>(mesh, {});
  ASSERT_TRUE(plain);
  EXPECT_FALSE(plain->structure.has(KdExtras::ropes));
}

}  // namespace
}  // namespace accel
