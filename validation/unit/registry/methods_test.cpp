// The registry's lists, and that a new traverser is one type and one line.
#include "libaccel/registry/methods.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <set>
#include <type_traits>
#include <vector>

#include "libaccel/exec/count_rays.h"
#include "libaccel/exec/multipass.h"
#include "libaccel/exec/simt.h"
#include "libaccel/registry/instantiate_method.h"
#include "libaccel/registry/structures.h"
#include "validation/stress/stress_rays.h"
#include "validation/stress/stress_scenes.h"

namespace accel {
namespace {

// A traverser that is in no registry: brute force from the last triangle to the first.
template <class Test, Query kQuery>
struct BackwardsLoop {
  static constexpr const char* kName = "backwards";
  using View = TriangleListView;

  struct State {
    typename Test::RayData test;
    std::uint32_t quad;
  };

  template <class Observer>
  ACCEL_HD static Phase begin(const View& view, const Ray& ray, State& state, Hit& hit, Observer&) {
    begin_hit(ray, hit);
    if (view.leaves == nullptr || !is_traceable(ray)) return Phase::done;
    state.test = Test::prepare(ray), state.quad = 0;
    while (!is_end_of_leaf(view.leaves, state.quad)) state.quad += kQuadsPerTriangle;
    return state.quad == 0 ? Phase::done : Phase::intersect;
  }
  template <class Observer>
  ACCEL_HD static Phase descend(const View&, const Ray&, State&, Hit&, Observer&) {
    return Phase::done;
  }
  template <class Observer>
  ACCEL_HD static Phase intersect(const View& view, const Ray& ray, State& state, Hit& hit, Observer& observer) {
    state.quad -= kQuadsPerTriangle;
    const PackedTriangle& triangle = packed_triangle(view.leaves, state.quad);
    observer.triangle_test();
    Hit candidate;
    if (Test::intersect(triangle, ray, state.test, candidate)) {
      candidate.prim_id = triangle.prim_id();
      if (accept_hit(candidate, first_t(ray), hit) && kQuery == Query::any) return Phase::done;
    }
    return state.quad == 0 ? Phase::done : Phase::intersect;
  }
  template <class Observer>
  ACCEL_HD static Phase backtrack(const View&, const Ray&, State&, Hit&, Observer&) {
    return Phase::done;
  }
};

using ExtendedMethods = Methods::AppendUnique<Method<ListBuilder, BackwardsLoop>>;

TEST(Methods, NamesAreUniqueAndHaveTwoParts) {
  std::set<std::string> names;
  ExtendedMethods::for_each([&](auto tag) {
    const std::string name = decltype(tag)::type::name();
    EXPECT_TRUE(names.insert(name).second) << name;
    EXPECT_EQ(std::count(name.begin(), name.end(), '/'), 1) << name;
  });
  EXPECT_TRUE(names.contains("brute/backwards"));
}

// Precomputed transforms take the place of vertices, and of links in the words beside them.
TEST(Methods, TransformsGoWhereThereIsRoom) {
  const auto can_hold = []<class Method>(std::type_identity<Method>) { return detail::can_hold<Method, BaldwinWeber>(); };
  EXPECT_TRUE(can_hold(std::type_identity<Method<ListBuilder, BruteForce>>{}));
  EXPECT_TRUE(can_hold(std::type_identity<Method<Sbvh, Bvh2Stack>>{}));
  EXPECT_TRUE(can_hold(std::type_identity<Method<KdTreeSah, KdTreeRopes>>{}));
  EXPECT_TRUE(can_hold(std::type_identity<Method<InstanceBuilder, InstancesStack>>{}));
  EXPECT_FALSE(can_hold(std::type_identity<Method<Sbvh, Bvh2Hash>>{}));
  EXPECT_FALSE(can_hold(std::type_identity<Method<Sbvh, Bvh2Uncle>>{}));
  EXPECT_FALSE(can_hold(std::type_identity<Method<InstanceBuilder, InstancesHash>>{}));
  EXPECT_FALSE(can_hold(std::type_identity<Method<WideSbvh, Bvh8Ordered>>{}));
}

TEST(Methods, StructuresAreListedOnce) {
  EXPECT_TRUE((std::is_same_v<Structures, ExtendedMethods::Apply<detail::UniqueStructures>>))
      << "no new structure, no new type";
}

// The registry takes the new method as it takes the listed ones, and every executor answers as brute force does.
TEST(Methods, ANewTraverserIsOneTypeAndOneLine) {
  const TriangleMesh mesh = validation::mesh_of(validation::random_triangles(60, 0.4f, 1));
  const std::vector<Ray> rays = validation::stress_rays(mesh, 2000);
  const Result<AnyAccel> brute = AnyAccel::build(mesh, "brute/loop");
  ASSERT_TRUE(brute) << brute.message();
  std::vector<Hit> expected(rays.size());
  ASSERT_TRUE(brute->closest(rays, expected));

  const MethodEntry entry = make_method_entry<Method<ListBuilder, BackwardsLoop>>();
  EXPECT_EQ(entry.info.name, "brute/backwards");
  const AnyStructure& list = brute->structure();
  ASSERT_TRUE(entry.check(list, entry.info));
  for (const TestEntry& test : entry.tests)
    EXPECT_EQ(count_rays(test.traverser(list, Query::closest, Machine::cpu), rays, {}, 1).rays, rays.size());

  const TestEntry& watertight = entry.tests[0];
  std::vector<Hit> hits(rays.size()), simulated(rays.size()), passed(rays.size());
  std::vector<std::uint8_t> occluded(rays.size());
  watertight.closest(list, rays, hits, 1);
  watertight.occluded(list, rays, occluded, 1);
  const AnyTraverser::View traverser = watertight.traverser(list, Query::closest, Machine::device);
  simulate_simt(traverser, rays, simulated, {}, 1);
  trace_multipass(traverser, rays, passed, {}, 1);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    EXPECT_EQ(hits[i].prim_id, expected[i].prim_id) << i;
    EXPECT_EQ(hits[i].t, expected[i].t) << i;
    EXPECT_EQ(occluded[i] != 0, expected[i].valid()) << i;
  }
  const auto same_hits = [&](const std::vector<Hit>& other) {
    return std::memcmp(other.data(), hits.data(), hits.size() * sizeof(Hit)) == 0;
  };
  EXPECT_TRUE(same_hits(simulated));
  EXPECT_TRUE(same_hits(passed));
}

}  // namespace
}  // namespace accel
