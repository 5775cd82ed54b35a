#include "libaccel/exec/simt.h"

#include <gtest/gtest.h>

#include <cstring>
#include <vector>

#include "libaccel/build/binned_sah.h"
#include "libaccel/build/triangle_list.h"
#include "libaccel/exec/count_rays.h"
#include "libaccel/exec/cpu.h"
#include "libaccel/geometry/triangle_mesh.h"
#include "libaccel/geometry/watertight.h"
#include "libaccel/rays/ray_sets.h"
#include "libaccel/registry/any_accel.h"
#include "libaccel/trace/brute_force.h"
#include "libaccel/trace/bvh2_stack.h"
#include "scenes/procedural.h"
#include "validation/unit/exec/soup_and_rays.h"

namespace accel {
namespace {

using test::kDeadRay;
using test::SoupAndRays;

using ClosestStack = Bvh2Stack<Watertight, Query::closest>;
using AnyStack = Bvh2Stack<Watertight, Query::any>;
using ClosestBrute = BruteForce<Watertight, Query::closest>;
using AnyBrute = BruteForce<Watertight, Query::any>;

constexpr SimtSchedule kSchedules[] = {SimtSchedule::while_while, SimtSchedule::if_if, SimtSchedule::speculative_while_while,
                                       SimtSchedule::persistent_while_while, SimtSchedule::if_while};

// `count` triangles side by side in planes z = 1, 2, ..., all across the z axis.
TriangleMesh stacked_triangles(std::uint32_t count) {
  TriangleMesh mesh;
  mesh.vertices = Buffer<Vec3>(3 * count);
  mesh.triangles = Buffer<IndexTriple>(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const float z = static_cast<float>(i + 1);
    mesh.vertices[3 * i] = {-1, -1, z}, mesh.vertices[3 * i + 1] = {1, -1, z}, mesh.vertices[3 * i + 2] = {0, 1, z};
    mesh.triangles[i] = {3 * i, 3 * i + 1, 3 * i + 2};
  }
  return mesh;
}

// A triangle soup and random rays, which diverge; built once.
const SoupAndRays& soup() {
  static const SoupAndRays scene(2000, 3000);
  return scene;
}

bool same_bytes(std::span<const Hit> a, std::span<const Hit> b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
}

bool same_profile(const SimtProfile& a, const SimtProfile& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

TEST(Simt, IdenticalRaysKeepAllLanesBusy) {
  const SoupAndRays& scene = soup();
  const std::vector<Ray> rays(32, scene.rays[0]);
  for (const SimtSchedule schedule : kSchedules) {
    const SimtProfile p = simulate_simt<ClosestStack>(scene.bvh.view(), rays, {}, {.schedule = schedule}, 1);
    EXPECT_EQ(p.warps, 1u);
    EXPECT_EQ(p.efficiency(), 1.0) << schedule_name(schedule);
    EXPECT_EQ(p.fetch.efficiency(), 1.0);
    ASSERT_GT(p.descend.steps, 0u);

    // All lanes ask for the same node: one line, both of its sectors that the node fills.
    const auto& nodes = p.of(Memory::node);
    EXPECT_EQ(nodes.requests, p.descend.steps);
    EXPECT_EQ(nodes.lines, nodes.requests);
    EXPECT_EQ(nodes.sectors, 2 * nodes.requests);
    EXPECT_EQ(nodes.bytes, 32 * sizeof(Bvh2Node) * nodes.requests);

    // Stack entries of two words, at the same depth in all lanes: word by word one line of 32 lanes.
    const auto& stack = p.of(Memory::stack);
    EXPECT_EQ(stack.lines, 2 * stack.requests);
    EXPECT_EQ(stack.sectors, 8 * stack.requests);
    EXPECT_EQ(stack.bytes, 32 * 8 * stack.requests);
  }
}

TEST(Simt, OneLaneOfThirtyTwo) {
  const SoupAndRays& scene = soup();
  std::vector<Ray> rays(32, kDeadRay);
  rays[13] = scene.rays[0];
  for (const SimtSchedule schedule : kSchedules) {
    const SimtProfile p = simulate_simt<ClosestStack>(scene.bvh.view(), rays, {}, {.schedule = schedule}, 1);
    ASSERT_GT(p.descend.steps, 0u);
    EXPECT_EQ(p.efficiency(), 1.0 / 32) << schedule_name(schedule);
    EXPECT_EQ(p.fetch.efficiency(), 1.0);
  }
}

TEST(Simt, NoRaysNoWarps) {
  const SimtProfile p = simulate_simt<ClosestStack>(soup().bvh.view(), {}, {}, {}, 1);
  EXPECT_TRUE(same_profile(p, SimtProfile{}));
  EXPECT_EQ(p.efficiency(), 1.0);
}

// Half of the lanes find their hit in the first of N triangles and stop; the others test all N.
TEST(Simt, AnyHitStopsLanesOneByOne) {
  constexpr std::uint32_t kTriangles = 10;
  const auto list = ListBuilder::build(stacked_triangles(kTriangles), {});
  ASSERT_TRUE(list.ok());
  std::vector<Ray> rays(32, Ray{.org = {0, 0, 0}, .dir = {0, 0, 1}});
  for (std::size_t i = 0; i < rays.size(); i += 2) rays[i].dir = {0, 0, -1};
  const SimtProfile p = simulate_simt<AnyBrute>(list->structure.view(), rays, {}, {}, 1);
  EXPECT_EQ(p.intersect.steps, kTriangles);
  EXPECT_EQ(p.intersect.active_lanes, 16u * 1 + 16u * kTriangles);
  EXPECT_EQ(p.descend.steps + p.backtrack.steps, 0u);
}

// The same lanes, persistent: 64 rays of which every other ends at once. Lanes that are done take the next rays.
TEST(Simt, PersistentLanesFetchWhenFewAreAtWork) {
  constexpr std::uint32_t kTriangles = 10;
  const auto list = ListBuilder::build(stacked_triangles(kTriangles), {});
  std::vector<Ray> rays(64, Ray{.org = {0, 0, 0}, .dir = {0, 0, 1}});
  for (std::size_t i = 0; i < rays.size(); i += 2) rays[i] = kDeadRay;
  const SimtOptions options{.schedule = SimtSchedule::persistent_while_while, .rays_per_warp = 64, .fetch_below = 20};
  const SimtProfile p = simulate_simt<ClosestBrute>(list->structure.view(), rays, {}, options, 1);
  EXPECT_EQ(p.warps, 1u);
  // Fetched: 32 rays, of which 16 live; as these are tested at once, the next 32 follow when they are done.
  EXPECT_EQ(p.fetch.active_lanes, 64u);
  EXPECT_EQ(p.intersect.active_lanes, 32u * kTriangles);
  EXPECT_EQ(p.intersect.steps, 2 * kTriangles);
}

template <class Traverser>
void expect_cpu_hits(const typename Traverser::View& view, std::span<const Ray> rays) {
  std::vector<Hit> expected(rays.size()), hits(rays.size());
  trace_closest<Traverser>(view, rays, expected, 1);
  for (const SimtSchedule schedule : kSchedules) {
    std::memset(static_cast<void*>(hits.data()), 0xab, hits.size() * sizeof(Hit));
    simulate_simt<Traverser>(view, rays, hits, {.schedule = schedule, .rays_per_warp = 100}, 2);
    EXPECT_TRUE(same_bytes(hits, expected)) << schedule_name(schedule);
  }
}

std::vector<Ray> rays_some_of_them_dead(std::size_t count) {
  std::vector<Ray> rays(soup().rays.begin(), soup().rays.begin() + static_cast<std::ptrdiff_t>(count));
  for (std::size_t i = 0; i < rays.size(); i += 50) rays[i] = kDeadRay;
  return rays;
}

TEST(Simt, HitsAreTheCpusBitForBit) {
  expect_cpu_hits<ClosestStack>(soup().bvh.view(), rays_some_of_them_dead(2000));
  expect_cpu_hits<AnyStack>(soup().bvh.view(), rays_some_of_them_dead(2000));
}

void expect_cpu_hits_of(const AnyAccel& accel, std::span<const Ray> rays, const std::string& test) {
  std::vector<Hit> expected(rays.size()), hits(rays.size());
  std::vector<std::uint8_t> expected_any(rays.size());
  ASSERT_TRUE(accel.closest(rays, expected, {.threads = 1, .test = test}));
  ASSERT_TRUE(accel.occluded(rays, expected_any, {.threads = 1, .test = test}));
  for (const SimtSchedule schedule : kSchedules) {
    SCOPED_TRACE(accel.method().name + " " + test + " " + schedule_name(schedule));
    const SimtOptions options{.schedule = schedule, .rays_per_warp = 100};
    std::memset(static_cast<void*>(hits.data()), 0xab, hits.size() * sizeof(Hit));
    ASSERT_TRUE(accel.profile_simt(rays, Query::closest, hits, options, {.threads = 2, .test = test}));
    EXPECT_TRUE(same_bytes(hits, expected));
    std::memset(static_cast<void*>(hits.data()), 0xab, hits.size() * sizeof(Hit));
    ASSERT_TRUE(accel.profile_simt(rays, Query::any, hits, options, {.threads = 2, .test = test}));
    for (std::size_t i = 0; i < rays.size(); ++i) EXPECT_EQ(hits[i].valid(), expected_any[i] != 0) << i;
  }
}

// As the library has compiled it for each method: here it would be compiled once more.
TEST(Simt, HitsAreTheCpusInEveryScheduleAndMethod) {
  const std::vector<Ray> rays = rays_some_of_them_dead(500);
  for (const MethodInfo& method : methods()) {
    const auto accel = AnyAccel::build(soup().mesh, method.name);
    ASSERT_TRUE(accel) << accel.message();
    for (const std::string& test : modelled_tests()) expect_cpu_hits_of(*accel, rays, test);
  }
}

TEST(Simt, StepsAndBytesAreWhatTheRaysCost) {
  const SoupAndRays& scene = soup();
  const Counters counters = count_rays<ClosestStack>(scene.bvh.view(), scene.rays, {}, 1);
  for (const SimtSchedule schedule :
       {SimtSchedule::while_while, SimtSchedule::if_if, SimtSchedule::persistent_while_while, SimtSchedule::if_while}) {
    const SimtProfile p = simulate_simt<ClosestStack>(scene.bvh.view(), scene.rays, {}, {.schedule = schedule}, 1);
    EXPECT_EQ(p.rays, scene.rays.size());
    EXPECT_EQ(p.fetch.active_lanes, scene.rays.size());
    EXPECT_EQ(p.descend.active_lanes, counters.node_steps);
    EXPECT_EQ(p.intersect.active_lanes, counters.triangle_tests);
    EXPECT_GE(p.backtrack.active_lanes, counters.backtracks);  // and once more a ray, to find the stack empty
    for (const Memory memory : {Memory::node, Memory::triangle, Memory::stack, Memory::hash})
      EXPECT_EQ(p.of(memory).bytes, counters.bytes[static_cast<int>(memory)]);
    EXPECT_EQ(p.of(Memory::ray).bytes, scene.rays.size() * (sizeof(Ray) + sizeof(Hit)));
    EXPECT_EQ(p.postponed_leaves, 0u);
  }
}

TEST(Simt, SpeculationFillsTheSearchAndCostsTests) {
  const SoupAndRays& scene = soup();
  const auto run = [&](SimtSchedule schedule) {
    return simulate_simt<ClosestStack>(scene.bvh.view(), scene.rays, {}, {.schedule = schedule}, 1);
  };
  const SimtProfile plain = run(SimtSchedule::while_while), speculative = run(SimtSchedule::speculative_while_while);
  EXPECT_GT(speculative.postponed_leaves, 0u);
  EXPECT_GT(speculative.descend.efficiency(), plain.descend.efficiency());
  EXPECT_GE(speculative.descend.active_lanes, plain.descend.active_lanes);
  EXPECT_GE(speculative.intersect.active_lanes, plain.intersect.active_lanes);
}

TEST(Simt, TraversersThatCannotSpeculateRunWhileWhile) {
  static_assert(SpeculativeTraverser<ClosestStack> && !SpeculativeTraverser<ClosestBrute>);
  const SoupAndRays& scene = soup();
  const auto rays = std::span(scene.rays).first(64);
  const auto plain = simulate_simt<ClosestBrute>(scene.list.view(), rays, {}, {.schedule = SimtSchedule::while_while}, 1);
  const auto speculative =
      simulate_simt<ClosestBrute>(scene.list.view(), rays, {}, {.schedule = SimtSchedule::speculative_while_while}, 1);
  EXPECT_TRUE(same_profile(plain, speculative));
}

TEST(Simt, FetchingKeepsMoreLanesBusyThanWaiting) {
  const SoupAndRays& scene = soup();
  const auto run = [&](SimtSchedule schedule) {
    return simulate_simt<ClosestStack>(scene.bvh.view(), scene.rays, {}, {.schedule = schedule}, 1);
  };
  EXPECT_GT(run(SimtSchedule::persistent_while_while).efficiency(), run(SimtSchedule::while_while).efficiency());
}

TEST(Simt, ProfilesDoNotDependOnThreads) {
  const SoupAndRays& scene = soup();
  for (const SimtSchedule schedule : kSchedules) {
    const SimtOptions options{.schedule = schedule, .rays_per_warp = 64};
    const SimtProfile one = simulate_simt<ClosestStack>(scene.bvh.view(), scene.rays, {}, options, 1);
    for (const int threads : {2, 3, 0})
      EXPECT_TRUE(same_profile(one, simulate_simt<ClosestStack>(scene.bvh.view(), scene.rays, {}, options, threads)));
  }
}

TEST(WarpRequests, CountsDistinctLinesAndSectors) {
  WarpRequests requests;
  SimtProfile profile;
  const auto traffic = [&] { return profile.of(Memory::node); };

  // 32 lanes, 4 bytes each, side by side: one line, four sectors.
  for (std::uint64_t lane = 0; lane < 32; ++lane) requests.add(Memory::node, false, 0, 1024 + 4 * lane, 4);
  requests.close(profile);
  EXPECT_EQ(traffic().requests, 1u);
  EXPECT_EQ(traffic().lines, 1u);
  EXPECT_EQ(traffic().sectors, 4u);
  EXPECT_EQ(traffic().bytes, 128u);

  // Two lanes that straddle a line boundary, in the wrong order, and a second load of one of them.
  profile = {};
  requests.add(Memory::node, false, 0, 4096 + 120, 16);
  requests.add(Memory::node, false, 0, 120, 16);
  requests.add(Memory::node, false, 1, 120, 4);
  requests.close(profile);
  EXPECT_EQ(traffic().requests, 2u);
  EXPECT_EQ(traffic().lines, 4u + 1u);
  EXPECT_EQ(traffic().sectors, 4u + 1u);

  // Loads and stores never share a request.
  profile = {};
  requests.add(Memory::node, false, 0, 0, 4);
  requests.add(Memory::node, true, 0, 0, 4);
  requests.close(profile);
  EXPECT_EQ(traffic().requests, 2u);
}

TEST(LaneObserver, StackWordsAreInterleavedByLane) {
  struct Entry {
    std::uint32_t a, b;
  };
  struct {
    Entry entries[4];
  } stack[kWarpSize];
  const auto traffic_of = [&](auto slot_of_lane) {
    WarpRequests requests;
    SimtProfile profile;
    for (int lane = 0; lane < kWarpSize; ++lane) {
      LaneObserver observer(requests, &stack[lane], sizeof stack[lane], lane);
      observer.load(Memory::stack, &stack[lane].entries[slot_of_lane(lane)], sizeof(Entry));
    }
    requests.close(profile);
    return profile.of(Memory::stack);
  };
  const auto together = traffic_of([](int) { return 1; });
  EXPECT_EQ(together.lines, 2u);
  EXPECT_EQ(together.sectors, 8u);
  const auto apart = traffic_of([](int lane) { return lane % 2; });
  EXPECT_EQ(apart.lines, 4u);
  EXPECT_EQ(apart.sectors, 16u);
}

}  // namespace
}  // namespace accel
