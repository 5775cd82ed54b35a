// Methods that keep instances apart, against Embree's instances and exact arithmetic; methods that trace them as one mesh,
// against the others.
#include <algorithm>

#include "libaccel/geometry/mesh_facts.h"
#include "libaccel/rays/ray_sets.h"
#include "scenes/procedural.h"
#include "validation/compare/compare.h"
#include "validation/conformance/method_test.h"
#include "validation/oracle/embree.h"
#include "validation/stress/stress_instances.h"

namespace accel::validation {
namespace {

class Instances : public MethodTest {
 protected:
  void SetUp() override {
    const auto is_tested = [](const MethodInfo& m) { return m.name == GetParam().method; };
    keeps_apart_ = std::find_if(methods().begin(), methods().end(), is_tested)->instances;
  }

  static AnyAccel build(const InstancedMeshes& scene) {
    Result<AnyAccel> accel = AnyAccel::build(scene, GetParam().method);
    if (!accel) throw std::runtime_error(accel.message());
    return *std::move(accel);
  }

  // What the method traces: the instances, or their triangles rounded to floats.
  Judge judge_of(const InstancedMeshes& scene) const { return keeps_apart_ ? Judge(scene) : Judge(*scene.flattened()); }

  void expect_no_failures(const std::string& what, const InstancedMeshes& scene, const std::vector<Ray>& rays) const {
    std::vector<Hit> theirs;
    std::vector<std::uint8_t> theirs_any;
    if (EmbreeWitness::available()) {
      const EmbreeOptions options{.build_threads = 1};
      const auto embree =
          keeps_apart_ ? EmbreeWitness::build(scene, options) : EmbreeWitness::build(*scene.flattened(), options);
      ASSERT_TRUE(embree) << embree.message();
      theirs.resize(rays.size()), theirs_any.resize(rays.size());
      embree->closest(rays, theirs, 1), embree->occluded(rays, theirs_any, 1);
    }
    const Judge judge = judge_of(scene);
    const AnyAccel accel = build(scene);
    expect_clean(what + ", closest hits", compare(judge, rays, closest(accel, rays), theirs));
    expect_clean(what + ", any hits", compare_any(judge, rays, occluded(accel, rays), theirs_any));
  }

 private:
  static void expect_clean(const std::string& what, const Result<CheckResult>& check) {
    ASSERT_TRUE(check) << check.message();
    EXPECT_EQ(check->ours.miss, 0u) << what;
    EXPECT_EQ(check->ours.far, 0u) << what;
    EXPECT_EQ(check->ours.false_hit, 0u) << what;
  }

  bool keeps_apart_ = false;
};

TEST_P(Instances, NoFailuresOnScenesThatHurt) {
  for (const InstancedScene& s : instanced_scenes(3)) expect_no_failures(s.name, s.scene, instance_rays(s.scene, 500, 3));
}

TEST_P(Instances, NoFailuresInTheForest) {
  const Result<SceneData> data = make_builtin("forest:3000");
  ASSERT_TRUE(data) << data.message();
  for (const auto& set : {edge_rays(*data->instances, 1500), random_rays(mesh_facts(*data->instances).bounds, 1500)}) {
    ASSERT_TRUE(set) << set.message();
    expect_no_failures("forest", *data->instances, {set->rays.begin(), set->rays.end()});
  }
}

// The numbers mean the same triangles, whichever way a scene is traced.
TEST_P(Instances, NamesTheTrianglesThatOtherMethodsName) {
  const InstancedScene s = instanced_scenes(4)[7];
  const auto set = random_rays(mesh_facts(s.scene).bounds, 5000, 4);
  ASSERT_TRUE(set) << set.message();
  const std::vector<Ray> rays(set->rays.begin(), set->rays.end());
  const Result<AnyAccel> other = AnyAccel::build(s.scene, "sbvh/stack");
  ASSERT_TRUE(other) << other.message();
  const std::vector<Hit> hits = closest(build(s.scene), rays), expected = closest(*other, rays);
  std::size_t different = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) different += hits[i].prim_id != expected[i].prim_id;
  EXPECT_LE(different, rays.size() / 1000) << "random rays do not pass edges by a hair";
}

TEST_P(Instances, FlatteningIsReported) {
  const InstancedScene s = instanced_scenes(5)[7];
  const AnyAccel accel = build(s.scene);
  const std::vector<BuildNote>& notes = accel.report().notes;
  const auto is_about_instances = [](const BuildNote& note) { return note.what == "instances"; };
  const auto note = std::find_if(notes.begin(), notes.end(), is_about_instances);
  ASSERT_NE(note, notes.end());
  EXPECT_EQ(note->why.find("flattened") == std::string::npos, accel.method().instances) << note->why;
}

}  // namespace

ACCEL_FOR_EVERY_PROMISE(Instances);

}  // namespace accel::validation
