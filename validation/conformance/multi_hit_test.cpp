// Every method finds all hits of a ray, in order and each once: those of brute force, of Embree, and of exact arithmetic.
#include <algorithm>
#include <cstring>

#include "libaccel/geometry/mesh_facts.h"
#include "libaccel/geometry/moeller_trumbore.h"
#include "libaccel/geometry/watertight.h"
#include "libaccel/rays/ray_sets.h"
#include "libaccel/registry/multi_hit.h"
#include "scenes/procedural.h"
#include "validation/compare/judge_hits.h"
#include "validation/conformance/method_test.h"
#include "validation/oracle/brute_hits.h"
#include "validation/oracle/embree.h"
#include "validation/stress/stress_instances.h"
#include "validation/stress/stress_rays.h"
#include "validation/stress/stress_scenes.h"

namespace accel::validation {
namespace {

using HitList = std::vector<Hit>;

// Whether two lists are the same, bit for bit.
bool is_same(const HitList& a, const HitList& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Hit)) == 0);
}

class MultiHit : public MethodTest {
 protected:
  static constexpr std::size_t kAll = 1000;  // more than any ray here has

  static bool keeps_instances_apart() {
    const auto is_tested = [](const MethodInfo& m) { return m.name == GetParam().method; };
    return std::find_if(methods().begin(), methods().end(), is_tested)->instances;
  }
  using MethodTest::build;
  static AnyAccel build(const InstancedMeshes& scene) {
    Result<AnyAccel> accel = AnyAccel::build(scene, GetParam().method);
    if (!accel) throw std::runtime_error(accel.message());
    return *std::move(accel);
  }

  // The k nearest hits of each ray, behind others if there are any.
  static std::vector<HitList> nearest(const AnyAccel& accel, const std::vector<Ray>& rays, std::size_t k,
                                      const HitList& after = {}, int threads = 1) {
    HitList hits(rays.size() * k);
    std::vector<std::uint32_t> counts(rays.size());
    const TraceOptions options{.threads = threads, .test = GetParam().test};
    const Status status = after.empty() ? accel.k_nearest(rays, k, hits, counts, options)
                                        : accel.next_hits(rays, after, k, hits, counts, options);
    EXPECT_TRUE(status) << status.message();
    std::vector<HitList> lists;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const auto first = hits.begin() + static_cast<std::ptrdiff_t>(i * k);
      lists.emplace_back(first, first + counts[i]);
      EXPECT_TRUE(
          std::all_of(first + counts[i], first + static_cast<std::ptrdiff_t>(k), [](const Hit& h) { return h == Hit{}; }));
    }
    return lists;
  }
  template <class Scene>
  static std::vector<HitList> brute_force(const Scene& scene, const std::vector<Ray>& rays) {
    std::vector<HitList> lists;
    for (const Ray& ray : rays)
      lists.push_back(GetParam().test == Watertight::kName ? all_hits<Watertight>(scene, ray)
                                                           : all_hits<MoellerTrumbore>(scene, ray));
    return lists;
  }

  // As expect_same() of single hits, whose limits are those of one hit a ray; a ray has several here.
  static void expect_same_lists(const std::string& what, const Judge& judge, const std::vector<Ray>& rays,
                                const std::vector<HitList>& ours, const std::vector<HitList>& expected) {
    if (!is_watertight() && what == "slivers") return;
    std::size_t different = 0, hits = rays.size();
    for (std::size_t i = 0; i < rays.size(); ++i) {
      hits += expected[i].size();
      if (is_same(ours[i], expected[i])) continue;
      ++different;
      if (!is_watertight()) continue;
      EXPECT_EQ(judge_hits(judge, rays[i], ours[i]).failures(), 0u) << what << ", ray " << i;
    }
    EXPECT_LE(different, 1 + hits / (is_watertight() ? 1000 : 100)) << what;
  }
};

TEST_P(MultiHit, AllHitsAsBruteForce) {
  std::size_t most = 0;
  for (const StressScene& scene : stress_scenes(81)) {
    const std::vector<Ray> rays = stress_rays(scene.mesh, 200, 81);
    const std::vector<HitList> expected = brute_force(scene.mesh, rays);
    expect_same_lists(scene.name, Judge(scene.mesh), rays, nearest(build(scene.mesh), rays, kAll), expected);
    for (const HitList& list : expected) most = std::max(most, list.size());
  }
  EXPECT_GT(most, 50u) << "the rays test nothing";
}

TEST_P(MultiHit, TheNearestAreTheFirstOfAll) {
  for (const StressScene& scene : stress_scenes(82)) {
    const std::vector<Ray> rays = stress_rays(scene.mesh, 200, 82);
    const AnyAccel accel = build(scene.mesh);
    const Judge judge(scene.mesh);
    const std::vector<HitList> all = nearest(accel, rays, kAll);
    for (const std::size_t k : {1u, 2u, 7u}) {
      std::vector<HitList> expected = all;
      for (HitList& list : expected) list.resize(std::min(k, list.size()));
      const std::vector<HitList> lists = nearest(accel, rays, k);
      std::size_t different = 0;
      for (std::size_t i = 0; i < rays.size(); ++i) different += !is_same(lists[i], expected[i]);
      EXPECT_LE(different, 1 + rays.size() / 100) << scene.name << ", k = " << k;
      if (k != 1) continue;
      const std::vector<Hit> hits = closest(accel, rays);
      for (std::size_t i = 0; i < rays.size(); ++i) EXPECT_EQ(lists[i].empty() ? Hit{} : lists[i][0], hits[i]) << scene.name;
    }
  }
}

TEST_P(MultiHit, GoesOnBehindItsLastHit) {
  for (const StressScene& scene : stress_scenes(83)) {
    if (!is_watertight() && scene.name == "slivers") continue;
    const std::vector<Ray> rays = stress_rays(scene.mesh, 100, 83);
    const AnyAccel accel = build(scene.mesh);
    const std::vector<HitList> all = nearest(accel, rays, kAll);
    std::vector<HitList> chained(rays.size());
    HitList after(rays.size(), Hit{.t = -1});
    for (bool goes_on = true; goes_on;) {
      goes_on = false;
      const std::vector<HitList> some = nearest(accel, rays, 3, after);
      for (std::size_t i = 0; i < rays.size(); ++i) {
        chained[i].insert(chained[i].end(), some[i].begin(), some[i].end());
        after[i] = some[i].empty() ? Hit{} : some[i].back();
        goes_on |= !some[i].empty();
      }
    }
    std::size_t different = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      different += !is_same(chained[i], all[i]);
      EXPECT_LE(chained[i].size(), scene.mesh.size());
    }
    EXPECT_LE(different, 1 + rays.size() / 50) << scene.name;
  }
}

TEST_P(MultiHit, EqualHitsComeInTheOrderOfTheirNumbers) {
  std::vector<Triangle> copies(50, Triangle{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  copies.insert(copies.end(), 30, Triangle{{0, 0, -1}, {1, 0, -1}, {0, 1, -1}});
  const std::vector<Ray> rays(1, {.org = {0.25f, 0.25f, 1}, .dir = {0, 0, -1}});
  const AnyAccel accel = build(mesh_of(copies));
  for (const std::size_t k : {1u, 49u, 50u, 51u, 80u, 100u}) {
    const HitList list = nearest(accel, rays, k)[0];
    ASSERT_EQ(list.size(), std::min<std::size_t>(k, copies.size()));
    for (std::uint32_t i = 0; i < list.size(); ++i) {
      EXPECT_EQ(list[i].prim_id, i);
      EXPECT_EQ(list[i].t, i < 50 ? 1.0f : 2.0f);
    }
  }
}

TEST_P(MultiHit, HoldsToTheRaysInterval) {
  const TriangleMesh mesh = mesh_of(random_triangles(200, 0.6f, 84));
  const AnyAccel accel = build(mesh);
  std::vector<Ray> rays = stress_rays(mesh, 300, 84);
  const std::vector<HitList> all = nearest(accel, rays, kAll);
  for (std::size_t i = 0; i < rays.size(); ++i)
    if (all[i].size() > 2) rays[i].t_min = all[i][1].t, rays[i].t_max = all[i][all[i].size() - 2].t;
  expect_same_lists("random triangles", Judge(mesh), rays, nearest(accel, rays, kAll), brute_force(mesh, rays));
}

TEST_P(MultiHit, RaysThatAreNoRaysHaveNoHits) {
  const TriangleMesh mesh = mesh_of(random_triangles(100, 0.6f, 85));
  const AnyAccel accel = build(mesh);
  const std::vector<Ray> rays = invalid_rays();
  for (const HitList& list : nearest(accel, rays, 4)) EXPECT_TRUE(list.empty());
  for (const HitList& list : nearest(accel, rays, 4, HitList(rays.size(), Hit{.t = 0.5f, .prim_id = 3})))
    EXPECT_TRUE(list.empty());
  const std::vector<Ray> good = stress_rays(mesh, 100, 85);
  for (const HitList& list : nearest(accel, good, 4, HitList(good.size()))) EXPECT_TRUE(list.empty()) << "behind a miss";
}

TEST_P(MultiHit, ForAnyNumberOfThreads) {
  const TriangleMesh mesh = mesh_of(random_triangles(200, 0.4f, 86));
  const std::vector<Ray> rays = stress_rays(mesh, 3000, 86);
  const AnyAccel accel = build(mesh);
  const std::vector<HitList> one = nearest(accel, rays, 5);
  for (const int threads : {2, 0}) EXPECT_TRUE(nearest(accel, rays, 5, {}, threads) == one) << threads;
}

TEST_P(MultiHit, ForEachHitVisitsAllOfThemInOrder) {
  if (!is_watertight()) GTEST_SKIP() << "single rays use the first test";
  for (const StressScene& scene : stress_scenes(87)) {
    const std::vector<Ray> rays = stress_rays(scene.mesh, 100, 87);
    const AnyAccel accel = build(scene.mesh);
    const std::vector<HitList> all = nearest(accel, rays, kAll);
    std::size_t different = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      HitList visited;
      const auto keep = [&](const Hit& hit) { return visited.push_back(hit), true; };
      const std::size_t visits = for_each_hit(accel, rays[i], keep);
      EXPECT_EQ(visits, visited.size());
      different += !is_same(visited, all[i]);
    }
    EXPECT_LE(different, 1 + rays.size() / 100) << scene.name;
  }
}

TEST_P(MultiHit, OfInstances) {
  for (const InstancedScene& s : instanced_scenes(88)) {
    const std::vector<Ray> rays = instance_rays(s.scene, 100, 88);
    const AnyAccel accel = build(s.scene);
    const std::vector<HitList> lists = nearest(accel, rays, kAll);
    if (keeps_instances_apart())
      expect_same_lists(s.name, Judge(s.scene), rays, lists, brute_force(s.scene, rays));
    else
      expect_same_lists(s.name, Judge(*s.scene.flattened()), rays, lists, brute_force(*s.scene.flattened(), rays));
  }
}

class MultiHitAgainstEmbree : public MultiHit {
 protected:
  void SetUp() override {
    if (!EmbreeWitness::available()) GTEST_SKIP() << EmbreeWitness::version();
  }

  // Ours pass the judge, whatever Embree says. Where neither list has a hit that rounding decides about, they name the same
  // triangles: the number of such rays is returned.
  template <class Scene>
  static std::size_t expect_no_failures(const std::string& name, const Scene& scene, const std::vector<Ray>& rays) {
    const Result<EmbreeWitness> embree = EmbreeWitness::build(scene, {.build_threads = 1, .all_hits = true});
    EXPECT_TRUE(embree) << embree.message();
    if (!embree) return 0;
    std::vector<HitList> theirs(rays.size());
    embree->all_hits(rays, theirs, 1);
    const std::vector<HitList> ours = nearest(build(scene), rays, kAll);
    const Judge judge(scene);
    std::size_t disputed = 0, compared = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const HitsVerdict verdict = judge_hits(judge, rays[i], ours[i]), witness = judge_hits(judge, rays[i], theirs[i]);
      EXPECT_EQ(verdict.failures(), 0u) << name << ", ray " << i;
      if (verdict.edge + witness.edge + witness.failures() > 0) continue;
      ++compared;
      disputed += numbers_of(ours[i]) != numbers_of(theirs[i]);
    }
    EXPECT_EQ(disputed, 0u) << name << ": beyond doubt, there is one answer";
    return compared;
  }
  static std::vector<std::uint32_t> numbers_of(const HitList& hits) {
    std::vector<std::uint32_t> numbers;
    for (const Hit& hit : hits) numbers.push_back(hit.prim_id);
    std::sort(numbers.begin(), numbers.end());
    return numbers;
  }
};

TEST_P(MultiHitAgainstEmbree, OnScenesThatHurt) {
  std::size_t compared = 0;
  for (const StressScene& scene : stress_scenes(89))
    compared += expect_no_failures(scene.name, scene.mesh, stress_rays(scene.mesh, 120, 89));
  EXPECT_GT(compared, 300u);
}

TEST_P(MultiHitAgainstEmbree, OnProceduralScenes) {
  std::size_t compared = 0;
  for (const BuiltinScene& builtin : builtin_scenes()) {
    const Result<SceneData> scene = make_builtin(std::string(builtin.name) + ":1000");
    ASSERT_TRUE(scene) << scene.message();
    const TriangleMesh mesh = *scene->one_mesh();
    for (const auto& set : {edge_rays(mesh, 60), random_rays(mesh_facts(mesh).bounds, 150)}) {
      ASSERT_TRUE(set) << set.message();
      compared += expect_no_failures(std::string(builtin.name), mesh, {set->rays.begin(), set->rays.end()});
    }
  }
  EXPECT_GT(compared, 500u);
}

TEST_P(MultiHitAgainstEmbree, OnInstances) {
  if (!keeps_instances_apart()) GTEST_SKIP() << "traces them as one mesh";
  std::size_t compared = 0;
  for (const InstancedScene& s : instanced_scenes(90))
    if (s.scene.size() > 0) compared += expect_no_failures(s.name, s.scene, instance_rays(s.scene, 300, 90));
  EXPECT_GT(compared, 500u);
}

}  // namespace

ACCEL_FOR_EVERY_METHOD(MultiHit);
ACCEL_FOR_EVERY_PROMISE(MultiHitAgainstEmbree);

}  // namespace accel::validation
