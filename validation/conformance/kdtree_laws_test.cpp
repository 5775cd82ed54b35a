// The laws of Foley and Sugerman 2005, sections 2.2 and 2.3, and of the kd-tree's other traversers: all of them visit the
// leaves that the stack version visits, in its order, test the same triangles and find the same hits, and each keeps its bound
// on steps.
#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <vector>

#include "libaccel/build/kdtree_links.h"
#include "libaccel/build/kdtree_ropes.h"
#include "libaccel/build/kdtree_sah.h"
#include "libaccel/exec/drive.h"
#include "libaccel/geometry/watertight.h"
#include "libaccel/trace/kdtree_backtrack.h"
#include "libaccel/trace/kdtree_restart.h"
#include "libaccel/trace/kdtree_ropes.h"
#include "libaccel/trace/kdtree_short_stack.h"
#include "libaccel/trace/kdtree_stack.h"
#include "scenes/procedural.h"
#include "validation/stress/random_kdtrees.h"
#include "validation/stress/stress_cells.h"
#include "validation/stress/stress_rays.h"
#include "validation/stress/stress_scenes.h"

namespace accel::validation {
namespace {

// What a traversal did, in order.
struct KdTreeRecord {
  std::vector<std::uint32_t> leaves;
  std::vector<const void*> triangles;
  std::uint64_t node_steps = 0, backtracks = 0;
  Hit hit;
};

struct KdTreeRecorder : NullObserver {
  KdTreeRecord record;

  void load(Memory memory, const void* address, std::uint32_t bytes) {
    if (memory == Memory::triangle && bytes == sizeof(PackedTriangle)) record.triangles.push_back(address);
  }
  void node_step() { ++record.node_steps; }
  void leaf_visit(std::uint32_t node) { record.leaves.push_back(node); }
  void backtrack() { ++record.backtracks; }
};

template <template <class, Query> class Traverser, Query kQuery>
KdTreeRecord kdtree_record_of(const KdTree& tree, const Ray& ray) {
  KdTreeRecorder observer;
  observer.record.hit = trace_ray<Traverser<Watertight, kQuery>>(tree.view(), ray, observer);
  return observer.record;
}

KdTree built(const TriangleMesh& mesh) {
  Result<Built<KdTree>> result = KdTreeSah::build(mesh, {});
  EXPECT_TRUE(result);
  return result ? std::move(result->structure) : KdTree{};
}

class KdTreeLawsOf {
 public:
  KdTreeLawsOf(std::string name, KdTree tree) : name_(std::move(name)), tree_(std::move(tree)) {
    add_links(tree_), add_ropes(tree_);
  }

  void check(const std::vector<Ray>& rays) {
    for (std::size_t i = 0; i < rays.size() && !testing::Test::HasFailure(); ++i) {
      SCOPED_TRACE(name_ + ", ray " + std::to_string(i));
      check<Query::closest>(rays[i]);
      check<Query::any>(rays[i]);
    }
  }

 private:
  template <Query kQuery>
  void check(const Ray& ray) {
    const KdTreeRecord stack = kdtree_record_of<KdTreeStack, kQuery>(tree_, ray);
    const KdTreeRecord restart = kdtree_record_of<KdTreeRestart, kQuery>(tree_, ray);
    const KdTreeRecord backtrack = kdtree_record_of<KdTreeBacktrack, kQuery>(tree_, ray);
    const KdTreeRecord short_stack = kdtree_record_of<KdTreeShortStack, kQuery>(tree_, ray);
    expect_same(restart, stack, "restart");
    expect_same(backtrack, stack, "backtrack");
    expect_same(short_stack, stack, "short stack");
    expect_same(kdtree_record_of<KdTreeRopes, kQuery>(tree_, ray), stack, "ropes");

    EXPECT_LE(restart.node_steps, restart.leaves.size() * tree_.depth);
    EXPECT_LE(short_stack.node_steps, restart.node_steps);
    EXPECT_GE(short_stack.node_steps, stack.node_steps);
    EXPECT_EQ(backtrack.node_steps, stack.node_steps);
    EXPECT_LE(backtrack.backtracks, 2 * stack.node_steps);
    EXPECT_TRUE(stack.node_steps == 0 || backtrack.node_steps + backtrack.backtracks < 3 * stack.node_steps);
  }

  static void expect_same(const KdTreeRecord& record, const KdTreeRecord& stack, const char* traverser) {
    EXPECT_EQ(record.leaves, stack.leaves) << traverser;
    EXPECT_EQ(record.triangles, stack.triangles) << traverser;
    EXPECT_EQ(std::memcmp(&record.hit, &stack.hit, sizeof(Hit)), 0) << traverser;
  }

  std::string name_;
  KdTree tree_;
};

TEST(KdTreeLaws, OnRandomTreesOverScenesThatHurt) {
  for (const StressScene& scene : stress_scenes(51)) {
    for (const std::uint64_t seed : {1, 2, 3}) {
      KdTreeLawsOf(scene.name, random_kdtree(scene.mesh, seed)).check(stress_rays(scene.mesh, 400, 52 + seed));
      KdTreeLawsOf(scene.name, random_kdtree(scene.mesh, seed + 10))
          .check(nearly_parallel_rays(scene.mesh, -149, -60, 50, seed));
    }
  }
}

TEST(KdTreeLaws, OnScenesAndRaysThatHurtCells) {
  for (const StressScene& scene : cell_stress_scenes()) {
    for (const std::uint64_t seed : {1, 2}) {
      KdTreeLawsOf laws(scene.name, random_kdtree(scene.mesh, seed));
      laws.check(cell_stress_rays(scene.mesh, 400, seed));
      laws.check(far_rays(scene.mesh, 1e3f, 50, seed));
    }
  }
}

TEST(KdTreeLaws, OnBuiltTrees) {
  for (const StressScene& scene : stress_scenes(56)) {
    KdTreeLawsOf laws(scene.name, built(scene.mesh));
    laws.check(stress_rays(scene.mesh, 300, 57));
  }
  for (const BuiltinScene& builtin : builtin_scenes()) {
    const Result<SceneData> scene = make_builtin(std::string(builtin.name) + ":1000");
    ASSERT_TRUE(scene) << scene.message();
    const TriangleMesh mesh = *scene->one_mesh();
    KdTreeLawsOf laws(std::string(builtin.name), built(mesh));
    laws.check(stress_rays(mesh, 300, 58));
  }
}

TEST(KdTreeLaws, OnDeepTrees) {
  const TriangleMesh mesh = mesh_of(random_triangles(200, 0.3f, 53));
  const KdTree tree = random_kdtree(mesh, 54, {.max_depth = 60, .leaf_size = 0});
  EXPECT_GT(tree.depth, 40u);
  KdTreeLawsOf("deep", tree).check(stress_rays(mesh, 500, 55));
}

}  // namespace
}  // namespace accel::validation
