// Traversal of instances against its twin without a structure, and against the single level where both must agree.
#include "libaccel/trace/two_level.h"

#include <gtest/gtest.h>

#include <cstring>
#include <vector>

#include "libaccel/build/instances.h"
#include "libaccel/build/sbvh.h"
#include "libaccel/build/wide_instances.h"
#include "libaccel/exec/cpu.h"
#include "libaccel/geometry/watertight.h"
#include "libaccel/registry/annotate.h"
#include "libaccel/trace/bvh8_instances.h"
#include "libaccel/trace/instances_hash.h"
#include "libaccel/trace/instances_stack.h"
#include "validation/oracle/brute_instances.h"
#include "validation/stress/stress_instances.h"
#include "validation/stress/stress_rays.h"
#include "validation/stress/stress_scenes.h"

namespace accel {
namespace {

using validation::brute_force;
using validation::InstancedScene;

// A traverser of two levels, and the builder of what it reads.
struct Stack {
  using Builder = InstanceBuilder;
  template <Query kQuery>
  using Traverser = TwoLevel<Bvh2Stack<Watertight, kQuery>, kQuery>;
};
template <class Path>
struct Hash {
  using Builder = InstanceBuilder;
  template <Query kQuery>
  using Traverser = TwoLevel<Bvh2HashWith<Watertight, kQuery, Path>, kQuery>;
};
struct Wide {
  using Builder = WideInstances;
  template <Query kQuery>
  using Traverser = Bvh8Instances<Watertight, kQuery>;
};

template <class Kind>
class TwoLevelTraversal : public testing::Test {
 protected:
  using Closest = typename Kind::template Traverser<Query::closest>;
  using Any = typename Kind::template Traverser<Query::any>;
  using Structure = typename Kind::Builder::Structure;

  // Step by step, ray by ray, whatever else the method has for batches.
  template <class Traverser>
  static Hit trace_alone(const Structure& bvh, const Ray& ray) {
    NullObserver observer;
    return trace_ray<Traverser>(bvh.view(), ray, observer);
  }

  static Structure built(const InstancedMeshes& scene) {
    // Reinsertion makes some trees deeper than the narrowest keys can tell.
    auto result = Kind::Builder::build(scene, {.reinsertion_rounds = 0});
    EXPECT_TRUE(result) << result.message();
    const Status annotated = annotate<Closest>(result->structure, "test", 0, result->report);
    EXPECT_TRUE(annotated) << annotated.message();
    EXPECT_LE(result->structure.depth, Closest::kMaxDepth);
    return std::move(result->structure);
  }

  static std::vector<Hit> closest(const Structure& bvh, const std::vector<Ray>& rays) {
    std::vector<Hit> hits;
    for (const Ray& ray : rays) hits.push_back(trace_alone<Closest>(bvh, ray));
    return hits;
  }
};
template <class Path>
struct HashRecent {
  using Builder = InstanceBuilder;
  template <Query kQuery>
  using Traverser = TwoLevel<Bvh2HashRecentWith<Watertight, kQuery, Path, 2>, kQuery>;
};
using Kinds = testing::Types<Stack, Wide, Hash<NodePath<std::uint32_t>>, Hash<NodePath<std::uint64_t>>, Hash<DeepPath>,
                             HashRecent<PackedPath>, HashRecent<NodePath<std::uint64_t>>>;
TYPED_TEST_SUITE(TwoLevelTraversal, Kinds);

void expect_same(const Hit& hit, const Hit& expected, const std::string& what) {
  EXPECT_EQ(hit.prim_id, expected.prim_id) << what;
  EXPECT_EQ(hit.t, expected.t) << what;
  EXPECT_EQ(hit.u, expected.u) << what;
  EXPECT_EQ(hit.v, expected.v) << what;
}

TYPED_TEST(TwoLevelTraversal, FindsWhatBruteForceFinds) {
  for (const InstancedScene& s : validation::instanced_scenes()) {
    const std::vector<Ray> rays = validation::instance_rays(s.scene, 2000);
    const auto bvh = this->built(s.scene);
    const std::vector<Hit> hits = this->closest(bvh, rays);
    std::size_t found = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      expect_same(hits[i], brute_force<Watertight>(s.scene, rays[i]), s.name + ", ray " + std::to_string(i));
      found += hits[i].valid();
    }
    EXPECT_TRUE(s.scene.size() == 0 || found > rays.size() / 10) << s.name << ": the rays test nothing";
  }
}

TYPED_TEST(TwoLevelTraversal, AnyHitIffClosestHit) {
  for (const InstancedScene& s : validation::instanced_scenes(2)) {
    const std::vector<Ray> rays = validation::instance_rays(s.scene, 2000, 2);
    const auto bvh = this->built(s.scene);
    const std::vector<Hit> hits = this->closest(bvh, rays);
    for (std::size_t i = 0; i < rays.size(); ++i)
      EXPECT_EQ(this->template trace_alone<typename TestFixture::Any>(bvh, rays[i]).valid(), hits[i].valid())
          << s.name << ", ray " << i;
  }
}

// One identity instance is the mesh itself, to the last bit.
TYPED_TEST(TwoLevelTraversal, IdentityChangesNothing) {
  for (const validation::StressScene& s : validation::stress_scenes()) {
    const std::vector<Ray> rays = validation::stress_rays(s.mesh, 1000);
    const auto scene = InstancedMeshes::make({s.mesh}, {Instance{}});
    ASSERT_TRUE(scene) << s.name << ": " << scene.message();
    const auto single = Sbvh::build(s.mesh, {});
    ASSERT_TRUE(single) << single.message();
    std::vector<Hit> expected(rays.size());
    trace_closest<Bvh2Stack<Watertight, Query::closest>>(single->structure.view(), rays, expected, 1);
    const std::vector<Hit> hits = this->closest(this->built(*scene), rays);
    for (std::size_t i = 0; i < rays.size(); ++i) expect_same(hits[i], expected[i], s.name + ", ray " + std::to_string(i));
  }
}

// Several identity instances of parts are the union of the parts: the numbers go on from part to part.
TYPED_TEST(TwoLevelTraversal, IdentityInstancesOfPartsAreTheirUnion) {
  const auto first = validation::random_triangles(80, 0.4f, 3), second = validation::random_triangles(50, 0.4f, 4);
  auto all = first;
  all.insert(all.end(), second.begin(), second.end());
  const auto scene = InstancedMeshes::make({validation::mesh_of(second), validation::mesh_of(first)}, {{1, {}}, {0, {}}});
  const auto whole = InstancedMeshes::make({validation::mesh_of(all)}, {Instance{}});
  ASSERT_TRUE(scene && whole);
  const std::vector<Ray> rays = validation::stress_rays(validation::mesh_of(all), 4000);
  const auto bvh = this->built(*scene);
  const std::vector<Hit> hits = this->closest(bvh, rays);
  for (std::size_t i = 0; i < rays.size(); ++i)
    expect_same(hits[i], brute_force<Watertight>(*whole, rays[i]), "ray " + std::to_string(i));
}

TYPED_TEST(TwoLevelTraversal, TiesGoToTheLowestNumber) {
  const TriangleMesh mesh = validation::mesh_of({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}});
  const std::vector<Instance> instances(20, Instance{0, validation::placed_at({3, 2, 1}, {1, 1, 1}, 5, 5)});
  const auto scene = InstancedMeshes::make({mesh}, instances);
  ASSERT_TRUE(scene);
  const std::vector<Ray> rays = validation::instance_rays(*scene, 1000);
  std::size_t found = 0;
  for (const Hit& hit : this->closest(this->built(*scene), rays)) {
    if (!hit.valid()) continue;
    EXPECT_EQ(hit.prim_id, 0u);
    ++found;
  }
  EXPECT_GT(found, 100u);
}

// After every step the state is copied, with its stacks, and what it was copied from is overwritten.
TYPED_TEST(TwoLevelTraversal, PausesAndResumesAtEveryStep) {
  using Traverser = typename TestFixture::Closest;
  struct Paused {
    StackOf<Traverser> stack;
    typename Traverser::State state;
  };
  const InstancedScene s = validation::instanced_scenes()[4];
  const auto bvh = this->built(s.scene);
  const auto view = bvh.view();
  for (const Ray& ray : validation::instance_rays(s.scene, 200)) {
    NullObserver observer;
    std::vector<Paused> at(2);
    attach_stack<Traverser>(at[0].state, at[0].stack);
    Hit hit;
    Phase phase = Traverser::begin(view, ray, at[0].state, hit, observer);
    for (std::size_t step = 0; phase != Phase::done; ++step) {
      Paused &from = at[step % 2], &to = at[(step + 1) % 2];
      to.stack = from.stack, to.state = from.state;
      attach_stack<Traverser>(to.state, to.stack);
      std::memset(static_cast<void*>(&from), 0xff, sizeof from);
      phase = phase == Phase::descend     ? Traverser::descend(view, ray, to.state, hit, observer)
              : phase == Phase::intersect ? Traverser::intersect(view, ray, to.state, hit, observer)
                                          : Traverser::backtrack(view, ray, to.state, hit, observer);
    }
    finish_hit(hit);
    expect_same(hit, brute_force<Watertight>(s.scene, ray), "paused");
  }
}

TYPED_TEST(TwoLevelTraversal, RaysThatAreNoRaysMiss) {
  const InstancedScene s = validation::instanced_scenes()[4];
  const std::vector<Ray> rays = validation::invalid_rays();
  for (const Hit& hit : this->closest(this->built(s.scene), rays)) EXPECT_FALSE(hit.valid());
}

}  // namespace
}  // namespace accel
