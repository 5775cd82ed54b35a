// The registry's lists, and that a new traverser is one type and one line.
#include "libaccel/registry/methods.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <vector>

#include "libaccel/exec/cpu.h"
#include "libaccel/exec/simt.h"
#include "libaccel/registry/annotate.h"
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

TEST(Methods, StructuresAreListedOnce) {
  EXPECT_TRUE((std::is_same_v<Structures, ExtendedMethods::Apply<detail::UniqueStructures>>))
      << "no new structure, no new type";
}

// All executors take the new method as they take the registered ones.
TEST(Methods, ANewTraverserIsOneTypeAndOneLine) {
  const TriangleMesh mesh = validation::mesh_of(validation::random_triangles(60, 0.4f, 1));
  const std::vector<Ray> rays = validation::stress_rays(mesh, 2000);
  std::vector<std::vector<Hit>> answers;
  ExtendedMethods::for_each([&](auto tag) {
    using M = typename decltype(tag)::type;
    using Closest = typename M::template Traverser<Watertight, Query::closest>;
    using Any = typename M::template Traverser<Watertight, Query::any>;
    const auto built = build_for<M>(mesh, {});
    ASSERT_TRUE(built) << built.message();
    std::vector<Hit> hits(rays.size()), simulated(rays.size());
    std::vector<std::uint8_t> occluded(rays.size());
    trace_closest<Closest>(built->structure.view(), rays, hits, 1);
    trace_any<Any>(built->structure.view(), rays, occluded, 1);
    simulate_simt<Closest>(built->structure.view(), rays, simulated, {}, 1);
    EXPECT_EQ(count_rays<Closest>(built->structure.view(), rays, {}, 1).rays, rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) {
      EXPECT_EQ(occluded[i] != 0, hits[i].valid()) << M::name() << ' ' << i;
      EXPECT_EQ(simulated[i].prim_id, hits[i].prim_id) << M::name() << ' ' << i;
    }
    answers.push_back(std::move(hits));
  });
  ASSERT_EQ(answers.size(), Methods::size + 1);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    EXPECT_EQ(answers.back()[i].prim_id, answers.front()[i].prim_id) << i;
    EXPECT_EQ(answers.back()[i].t, answers.front()[i].t) << i;
  }
}

}  // namespace
}  // namespace accel
