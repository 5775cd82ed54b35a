// Every method gives the answers of brute force, on scenes and with rays that hurt, for any number of threads.
#include <algorithm>

#include "validation/conformance/method_test.h"
#include "validation/stress/stress_rays.h"
#include "validation/stress/stress_scenes.h"

namespace accel::validation {
namespace {

class SameHits : public MethodTest {};

// Of rays that graze triangles, for which other tests than the watertight one have no bound.
class SameGrazingHits : public MethodTest {};

TEST_P(SameHits, AsBruteForce) {
  for (const StressScene& scene : stress_scenes()) {
    const std::vector<Ray> rays = stress_rays(scene.mesh, 2000);
    const std::vector<Hit> expected = closest(build_brute_force(scene.mesh), rays);
    expect_same(scene.name, Judge(scene.mesh), rays, closest(build(scene.mesh), rays), expected);

    const auto is_hit = [](const Hit& hit) { return hit.valid(); };
    const auto hits = static_cast<std::size_t>(std::count_if(expected.begin(), expected.end(), is_hit));
    EXPECT_TRUE(scene.mesh.size() == 0 || hits > rays.size() / 10) << scene.name << ": the rays test nothing";
  }
}

TEST_P(SameGrazingHits, AsBruteForceForNearlyParallelRays) {
  for (const StressScene& scene : stress_scenes(2)) {
    const std::vector<Ray> rays = nearly_parallel_rays(scene.mesh, -100, -60, 300);
    expect_same(scene.name, Judge(scene.mesh), rays, closest(build(scene.mesh), rays),
                closest(build_brute_force(scene.mesh), rays));
  }
}

// Components whose reciprocals overflow. In flat scenes, where the ray runs in the plane of everything, the sheared coordinates
// are denormals and no bound of the triangle test holds: left out.
TEST_P(SameGrazingHits, AsBruteForceForDenormalDirections) {
  for (const StressScene& scene : stress_scenes(2)) {
    const std::vector<Ray> rays = nearly_parallel_rays(scene.mesh, -149, -120, 300);
    expect_same(scene.name, Judge(scene.mesh), rays, closest(build(scene.mesh), rays),
                closest(build_brute_force(scene.mesh), rays));
  }
}

TEST_P(SameHits, SingleRaysAsBatches) {
  if (GetParam().test != triangle_tests().front()) GTEST_SKIP() << "single rays use the first test";
  for (const StressScene& scene : stress_scenes(4)) {
    const std::vector<Ray> rays = stress_rays(scene.mesh, 300, 3);
    const AnyAccel accel = build(scene.mesh);
    const std::vector<Hit> hits = closest(accel, rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      EXPECT_EQ(accel.closest(rays[i]), hits[i]) << scene.name << ", ray " << i;
      EXPECT_EQ(accel.occluded(rays[i]), hits[i].valid()) << scene.name << ", ray " << i;
    }
  }
}

TEST_P(SameHits, ForAnyNumberOfThreads) {
  const TriangleMesh mesh = mesh_of(random_triangles(400, 0.3f, 5));
  const std::vector<Ray> rays = stress_rays(mesh, 20'000, 4);
  const AnyAccel accel = build(mesh);
  const std::vector<Hit> hits = closest(accel, rays, 1);
  const std::vector<std::uint8_t> any = occluded(accel, rays, 1);
  for (const int threads : {2, 4, 0}) {
    EXPECT_TRUE(closest(accel, rays, threads) == hits) << threads << " threads";
    EXPECT_TRUE(occluded(accel, rays, threads) == any) << threads << " threads";
  }
}

// The build, too, may use any number of threads.
TEST_P(SameHits, ForAnyNumberOfBuildThreads) {
  const TriangleMesh mesh = mesh_of(random_triangles(3000, 0.1f, 6));
  const std::vector<Ray> rays = stress_rays(mesh, 1000, 5);
  const auto hits_of_build = [&](int threads) {
    const Result<AnyAccel> accel = AnyAccel::build(mesh, GetParam().method, {.threads = threads});
    EXPECT_TRUE(accel) << accel.message();
    return closest(*accel, rays);
  };
  const std::vector<Hit> hits = hits_of_build(1);
  for (const int threads : {2, 4}) EXPECT_TRUE(hits_of_build(threads) == hits) << threads << " threads";
}

TEST_P(SameHits, RaysThatAreNoRaysMiss) {
  const std::vector<Ray> rays = invalid_rays();
  for (const StressScene& scene : stress_scenes(5)) {
    const AnyAccel accel = build(scene.mesh);
    const std::vector<Hit> hits = closest(accel, rays);
    const std::vector<std::uint8_t> any = occluded(accel, rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      EXPECT_EQ(hits[i], Hit{}) << scene.name << ", ray " << i;
      EXPECT_EQ(any[i], 0) << scene.name << ", ray " << i;
    }
  }
}

TEST_P(SameHits, TheLowestNumberWinsAmongEquals) {
  const std::vector<Triangle> copies(50, Triangle{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  const std::vector<Hit> hits = closest(build(mesh_of(copies)), {{.org = {0.25f, 0.25f, 1}, .dir = {0, 0, -1}}});
  EXPECT_EQ(hits[0].prim_id, 0u);
  EXPECT_EQ(hits[0].t, 1.0f);
}

TEST_P(SameHits, WithoutObserversAndWithThem) {
  const TriangleMesh mesh = mesh_of(random_triangles(300, 0.3f, 7));
  const std::vector<Ray> rays = stress_rays(mesh, 1000, 6);
  const AnyAccel accel = build(mesh);
  std::vector<std::uint32_t> steps(rays.size());
  const Result<Counters> counters = accel.count(rays, Query::closest, steps, {.threads = 1, .test = GetParam().test});
  ASSERT_TRUE(counters);
  EXPECT_EQ(counters->rays, rays.size());
  std::uint64_t sum = 0;
  for (const std::uint32_t s : steps) sum += s;
  EXPECT_EQ(sum, counters->node_steps + counters->triangle_tests);
  EXPECT_GT(counters->triangle_tests, 0u);

  const Result<Counters> any = accel.count(rays, Query::any, {}, {.threads = 2, .test = GetParam().test});
  ASSERT_TRUE(any);
  EXPECT_LE(any->triangle_tests, counters->triangle_tests) << "stopping at the first hit costs more than finding the nearest";
}

}  // namespace

ACCEL_FOR_EVERY_METHOD(SameHits);
ACCEL_FOR_EVERY_PROMISE(SameGrazingHits);

}  // namespace accel::validation
