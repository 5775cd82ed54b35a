// Every method against Embree on random and generated scenes, with the exact judge between them: a hit of ours is never a miss,
// too far, or false.
#include "validation/oracle/embree.h"
#include "libaccel/rays/ray_sets.h"
#include "scenes/procedural.h"
#include "validation/compare/compare.h"
#include "validation/conformance/method_test.h"
#include "validation/stress/stress_rays.h"
#include "validation/stress/stress_scenes.h"

namespace accel::validation {
namespace {

class AgainstEmbree : public MethodTest {
 protected:
  void SetUp() override {
    if (!EmbreeWitness::available()) GTEST_SKIP() << EmbreeWitness::version();
  }

  static void expect_no_failures(const std::string& name, const TriangleMesh& mesh, const std::vector<Ray>& rays) {
    const Result<EmbreeWitness> embree = EmbreeWitness::build(mesh, {.build_threads = 1});
    ASSERT_TRUE(embree) << embree.message();
    const Judge judge(mesh);
    const AnyAccel accel = build(mesh);

    std::vector<Hit> theirs(rays.size());
    embree->closest(rays, theirs, 1);
    const Result<CheckResult> closest_check = compare(judge, rays, closest(accel, rays), theirs);
    ASSERT_TRUE(closest_check) << closest_check.message();
    expect_clean(name + ", closest hits", *closest_check);

    std::vector<std::uint8_t> theirs_any(rays.size());
    embree->occluded(rays, theirs_any, 1);
    const Result<CheckResult> any_check = compare_any(judge, rays, occluded(accel, rays), theirs_any);
    ASSERT_TRUE(any_check) << any_check.message();
    expect_clean(name + ", any hits", *any_check);
  }

 private:
  static void expect_clean(const std::string& what, const CheckResult& check) {
    EXPECT_EQ(check.ours.miss, 0u) << what;
    EXPECT_EQ(check.ours.far, 0u) << what;
    EXPECT_EQ(check.ours.false_hit, 0u) << what;
    EXPECT_EQ(check.unjudged, 0u) << what;
  }
};

TEST_P(AgainstEmbree, OnScenesThatHurt) {
  for (const StressScene& scene : stress_scenes(41))
    expect_no_failures(scene.name, scene.mesh, stress_rays(scene.mesh, 1000, 41));
}

TEST_P(AgainstEmbree, OnRandomTriangles) {
  for (const float size : {0.01f, 0.1f, 1.0f}) {
    const TriangleMesh mesh = mesh_of(random_triangles(500, size, 42));
    expect_no_failures("size " + std::to_string(size), mesh, stress_rays(mesh, 3000, 42));
  }
}

TEST_P(AgainstEmbree, OnProceduralScenes) {
  for (const BuiltinScene& builtin : builtin_scenes()) {
    const Result<SceneData> scene = make_builtin(std::string(builtin.name) + ":2000");
    ASSERT_TRUE(scene) << scene.message();
    Aabb bounds;
    const TriangleMesh mesh = *scene->one_mesh();
    for (const Vec3& v : mesh.vertices) bounds.extend(v);
    for (const auto& set : {edge_rays(mesh, 1500), random_rays(bounds, 1500)}) {
      ASSERT_TRUE(set) << set.message();
      expect_no_failures(std::string(builtin.name), mesh, {set->rays.begin(), set->rays.end()});
    }
  }
}

}  // namespace

ACCEL_FOR_EVERY_PROMISE(AgainstEmbree);

}  // namespace accel::validation
