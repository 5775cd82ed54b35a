#include "libaccel/registry/any_accel.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <set>
#include <utility>

#include "libaccel/structure/bvh2.h"
#include "libaccel/structure/triangle_list.h"
#include "validation/stress/stress_scenes.h"

namespace accel {
namespace {

using testing::HasSubstr;

TriangleMesh triangle() { return validation::mesh_of({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}); }

AnyAccel build(const char* method) {
  Result<AnyAccel> accel = AnyAccel::build(triangle(), method);
  EXPECT_TRUE(accel) << accel.message();
  return std::move(accel).value();
}

TEST(Registry, DescribesItsMethods) {
  std::set<std::string> names;
  for (const MethodInfo& info : methods()) {
    EXPECT_EQ(info.name, info.builder + "/" + info.traverser);
    EXPECT_FALSE(info.structure.empty());
    EXPECT_TRUE(names.insert(info.name).second) << info.name;
    const Result<std::string> found = find_method(info.name);
    ASSERT_TRUE(found);
    EXPECT_EQ(*found, info.name);
    EXPECT_EQ(build(info.name.c_str()).method().name, info.name);
  }
  EXPECT_TRUE(names.contains("brute/loop"));
  EXPECT_TRUE(names.contains(best_method()));
}

TEST(Registry, BestIsAMethod) {
  const Result<std::string> best = find_method("best");
  ASSERT_TRUE(best);
  EXPECT_EQ(*best, best_method());
}

TEST(Registry, BestServesTheStructureThatThereIs) {
  for (const MethodInfo& method : methods())
    for (const Query query : {Query::closest, Query::any}) {
      const std::string best = best_method({.builder = method.builder, .query = query});
      EXPECT_TRUE(build(method.name.c_str()).with_method(best)) << best << " for a structure of " << method.builder;
    }
  EXPECT_EQ(best_method({.builder = "nobody's"}), best_method());
  for (const bool instances : {false, true}) {
    EXPECT_EQ(best_method({.builder = "bvh8-instances", .instances = instances}), "bvh8-instances/stream");
    EXPECT_EQ(best_method({.builder = "bvh8", .instances = instances}), "bvh8/stream");
  }
}

TEST(AnyAccel, BestIsOfTheKindThatThereIs) {
  for (const MethodInfo& method : methods()) {
    const Result<AnyAccel> best = build(method.name.c_str()).with_method("best");
    ASSERT_TRUE(best) << method.name << ": " << best.message();
    EXPECT_EQ(best->method().structure, method.structure);
    EXPECT_EQ(best->closest(Ray{.org = {0.25f, 0.25f, 1}, .dir = {0, 0, -1}}).t, 1.0f) << method.name;
  }
  EXPECT_EQ(build("bvh8-fast/stream").with_method("best")->method().name, "bvh8/stream");
}

TEST(AnyAccel, BestKeepsManyCopiesApart) {
  const TriangleMesh mesh = validation::mesh_of(validation::random_triangles(1000, 0.1f, 1));
  for (const std::size_t copies : {2u, 1100u}) {
    const auto scene = *InstancedMeshes::make({mesh}, std::vector<Instance>(copies));
    const Result<AnyAccel> best = AnyAccel::build(scene, "best");
    ASSERT_TRUE(best) << best.message();
    EXPECT_EQ(best->method().name, copies == 2 ? "bvh8/stream" : "bvh8-instances/stream");
  }
}

TEST(Registry, ExhaustiveMethodsAreThoseThatTestEveryTriangle) {
  const TriangleMesh mesh = validation::mesh_of(validation::random_triangles(200, 0.01f, 1));
  const std::vector<Ray> rays(1, Ray{.org = {2, 2, 2}, .dir = {1, 0, 0}});
  for (const MethodInfo& method : methods()) {
    const Result<AnyAccel> accel = AnyAccel::build(mesh, method.name);
    ASSERT_TRUE(accel) << accel.message();
    const Result<Counters> counters = accel->count(rays, Query::closest);
    ASSERT_TRUE(counters) << counters.message();
    EXPECT_EQ(method.exhaustive, counters->triangle_tests == mesh.size()) << method.name;
  }
}

TEST(AnyStructure, IsWhatItWasMadeOf) {
  Bvh2 bvh;
  bvh.nodes = Buffer<Bvh2Node>(3);
  bvh.depth = 2;
  const AnyStructure any(bvh);
  EXPECT_EQ(any.kind(), Bvh2::kName);
  EXPECT_EQ(any.depth(), 2u);
  EXPECT_EQ(any.size_bytes(), 3 * sizeof(Bvh2Node));
  ASSERT_NE(any.get_if<Bvh2>(), nullptr);
  EXPECT_EQ(any.get_if<Bvh2>()->nodes.data(), bvh.nodes.data()) << "copies share their arrays";
  EXPECT_EQ(any.get_if<TriangleList>(), nullptr);
  const AnyStructure copy = any;
  EXPECT_EQ(copy.get_if<Bvh2>(), any.get_if<Bvh2>()) << "copies share the structure";
}

TEST(Registry, SuggestsWhatWasMeant) {
  const Result<std::string> found = find_method("bvh/stcak");
  ASSERT_FALSE(found);
  EXPECT_THAT(found.message(), HasSubstr("bvh/stcak"));
  EXPECT_THAT(found.message(), HasSubstr("did you mean 'bvh/stack'"));
  EXPECT_FALSE(AnyAccel::build(triangle(), "nonsense"));
}

TEST(AnyAccel, RefusesMeshesThatAreNone) {
  TriangleMesh mesh = triangle();
  mesh.triangles = Buffer<IndexTriple>::copy_of(std::vector<IndexTriple>{{0, 1, 3}});
  const Result<AnyAccel> accel = AnyAccel::build(mesh, "bvh/stack");
  ASSERT_FALSE(accel);
  EXPECT_THAT(accel.message(), HasSubstr("names vertex 3"));
}

TEST(AnyAccel, BindsOnlyStructuresOfItsKind) {
  const Result<AnyAccel> wrong = build("brute/loop").with_method("bvh/stack");
  ASSERT_FALSE(wrong);
  EXPECT_THAT(wrong.message(), HasSubstr("bvh/stack"));
  EXPECT_THAT(wrong.message(), HasSubstr("'bvh2'"));
  EXPECT_THAT(wrong.message(), HasSubstr("'list'"));
  EXPECT_TRUE(build("bvh/stack").with_method("bvh/stack"));
}

TEST(AnyAccel, RefusesTreesDeeperThanItsStack) {
  Bvh2 bvh = *build("bvh/stack").structure().get_if<Bvh2>();
  bvh.depth = kBvh2StackSize;
  EXPECT_TRUE(AnyAccel::bind(bvh, "bvh/stack"));
  bvh.depth = kBvh2StackSize + 1;
  const Result<AnyAccel> deep = AnyAccel::bind(bvh, "bvh/stack");
  ASSERT_FALSE(deep);
  EXPECT_THAT(deep.message(), HasSubstr("max_depth"));
}

TEST(AnyAccel, ChecksSpansAndTestNames) {
  const AnyAccel accel = build("bvh/stack");
  const std::vector<Ray> rays(2, {.org = {0.25f, 0.25f, 1}, .dir = {0, 0, -1}});
  std::vector<Hit> hits(1);
  std::vector<std::uint8_t> occluded(3);
  EXPECT_FALSE(accel.closest(rays, hits));
  EXPECT_FALSE(accel.occluded(rays, occluded));
  hits.resize(2);
  EXPECT_TRUE(accel.closest(rays, hits));
  const Status unknown = accel.closest(rays, hits, {.test = "watertite"});
  ASSERT_FALSE(unknown);
  EXPECT_THAT(unknown.message(), HasSubstr("did you mean 'watertight'"));
  EXPECT_TRUE(accel.closest(std::span<const Ray>(), std::span<Hit>()));
}

TEST(AnyAccel, MultipassAnswersAsClosestDoes) {
  const std::vector<Ray> rays = {{.org = {0.25f, 0.25f, 1}, .dir = {0, 0, -1}}, {.org = {2, 2, 1}, .dir = {0, 0, -1}}};
  for (const MethodInfo& info : methods()) {
    const AnyAccel accel = build(info.name.c_str());
    std::vector<Hit> expected(2), hits(2), any(2), too_few(1);
    ASSERT_TRUE(accel.closest(rays, expected));
    ASSERT_TRUE(accel.trace_multipass(rays, Query::closest, hits));
    ASSERT_TRUE(accel.trace_multipass(rays, Query::any, any));
    EXPECT_EQ(std::memcmp(hits.data(), expected.data(), sizeof(Hit) * hits.size()), 0) << info.name;
    EXPECT_TRUE(any[0].valid() && !any[1].valid()) << info.name;
    const auto profile = accel.trace_multipass(rays, Query::closest);
    ASSERT_TRUE(profile) << profile.message();
    const std::uint64_t tests = accel.count(rays, Query::closest)->triangle_tests;
    const std::uint64_t instances = info.instances ? rays.size() : 0;  // that the rays enter, one each
    EXPECT_EQ(profile->of(MultipassKernel::intersect).rays, tests + instances) << info.name;
    EXPECT_FALSE(accel.trace_multipass(rays, Query::closest, too_few));
    EXPECT_FALSE(accel.trace_multipass(rays, Query::closest, {}, {}, {.test = "watertite"}));
  }
}

TEST(AnyAccel, PacketsOfNothingAreNoOptions) {
  const std::vector<Ray> rays(600, Ray{.org = {0.25f, 0.25f, 1}, .dir = {0, 0, -1}});
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const PacketOptions& packets :
       {PacketOptions{.max_size = 0, .min_size = 0, .block_size = 0}, PacketOptions{.max_size = 0xffffffffu},
        PacketOptions{.budget = -1}, PacketOptions{.budget = nan}, PacketOptions{.budget = 1e30f}})
    for (const char* method : {"bvh8/stream", "sbvh/breadth-first"}) {
      std::vector<Hit> hits(rays.size());
      ASSERT_TRUE(build(method).closest(rays, hits, {.threads = 2, .packets = packets}));
      for (const Hit& hit : hits) EXPECT_EQ(hit.t, 1.0f) << method;
    }
}

TEST(AnyAccel, MovingLeavesAHandle) {
  AnyAccel first = build("bvh/stack");
  const AnyAccel second = std::move(first);
  EXPECT_EQ(first.method().name, "bvh/stack");  // NOLINT: what is asked
  EXPECT_EQ(&first.structure(), &second.structure());
  AnyStructure structure = first.structure();
  const AnyStructure other = std::move(structure);
  EXPECT_NE(structure.get_if<Bvh2>(), nullptr);
  InstancedMeshes scene = *InstancedMeshes::make({triangle()}, {Instance{}});
  const InstancedMeshes moved = std::move(scene);
  EXPECT_EQ(scene.size(), moved.size());
}

TEST(AnyAccel, CopiesShareTheirStructure) {
  const AnyAccel first = build("bvh/stack");
  const AnyAccel second = first;
  EXPECT_EQ(&first.structure(), &second.structure());
  EXPECT_EQ(first.size_bytes(), second.size_bytes());
  EXPECT_EQ(second.closest(Ray{.org = {0.25f, 0.25f, 1}, .dir = {0, 0, -1}}).t, 1.0f);
}

}  // namespace
}  // namespace accel
