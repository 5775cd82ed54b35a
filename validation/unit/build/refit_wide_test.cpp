#include "libaccel/build/refit_wide.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "libaccel/build/fast_wide_bvh.h"
#include "libaccel/build/wide_sbvh.h"
#include "libaccel/structure/bvh8_stats.h"
#include "libaccel/trace/bvh8_ordered.h"
#include "validation/unit/build/builder_checks.h"

namespace accel {
namespace {

using Traverser = Bvh8Ordered<Watertight, Query::closest>;
constexpr Aabb kBox{{-0.7f, -0.7f, -0.7f}, {0.7f, 0.7f, 0.7f}};

TriangleMesh moved(const TriangleMesh& mesh, Vec3 (*move)(Vec3)) {
  TriangleMesh result = mesh;
  result.vertices = Buffer<Vec3>::copy_of(mesh.vertices.span());
  for (Vec3& v : result.vertices) v = move(v);
  return result;
}
Vec3 twisted(Vec3 p) {
  const float angle = 1.5f * p.z;
  return {std::cos(angle) * p.x - std::sin(angle) * p.y, std::sin(angle) * p.x + std::cos(angle) * p.y, 1.2f * p.z};
}

// But for one: a twist gives triangles on a line an area, which the tree has no place for.
std::vector<test::NamedMesh> meshes_that_may_twist() {
  std::vector<test::NamedMesh> meshes = test::all_meshes();
  std::erase_if(meshes, [](const test::NamedMesh& mesh) { return mesh.name == "rejects"; });
  return meshes;
}

Bvh8 refitted(const Bvh8& bvh, const TriangleMesh& mesh, RefitCosts* costs = nullptr) {
  Result<RefittedBvh8> result = refit_wide(bvh, mesh, {});
  EXPECT_TRUE(result) << result.message();
  if (!result) return {};
  const Status valid = validate(result->structure, mesh.size());
  EXPECT_TRUE(valid) << valid.message();
  if (costs != nullptr) *costs = result->costs;
  return result->structure;
}

// Without spatial splits boxes are those of whole triangles already: a refit in place changes no byte.
TEST(RefitWide, InPlaceNothingChanges) {
  for (const auto& [name, mesh] : test::all_meshes()) {
    SCOPED_TRACE(name);
    const Bvh8 bvh = test::build<FastWideBvh>(mesh).structure;
    RefitCosts costs;
    EXPECT_TRUE(test::same_bytes(refitted(bvh, mesh, &costs), bvh));
    EXPECT_EQ(costs.before, costs.after);
  }
}

TEST(RefitWide, CostsAreThoseOfTheStatistics) {
  for (const auto& [name, mesh] : meshes_that_may_twist()) {
    SCOPED_TRACE(name);
    const Bvh8 bvh = test::build<WideSbvh>(mesh).structure;
    RefitCosts costs;
    const Bvh8 twist = refitted(bvh, moved(mesh, twisted), &costs);
    const double before = bvh8_stats(bvh, 1, 1).sah_cost, after = bvh8_stats(twist, 1, 1).sah_cost;
    EXPECT_NEAR(costs.before, before, 1e-9 * before);
    EXPECT_NEAR(costs.after, after, 1e-9 * after);
  }
}

// Trees with spatial splits too.
TEST(RefitWide, HitsAreThoseOfBruteForce) {
  for (const auto& [name, mesh] : meshes_that_may_twist()) {
    SCOPED_TRACE(name);
    const Bvh8 split = test::build<WideSbvh>(mesh).structure, fast = test::build<FastWideBvh>(mesh).structure;
    for (const TriangleMesh& target : {mesh, moved(mesh, twisted)})
      for (const Bvh8* bvh : {&split, &fast})
        test::expect_hits_of_brute_force<Traverser>(target, refitted(*bvh, target), kBox, 100);
  }
}

TEST(RefitWide, BytesDoNotDependOnThreads) {
  const TriangleMesh mesh = test::soup(70000, 0.05f), target = moved(mesh, twisted);
  const Bvh8 bvh = test::build<FastWideBvh>(mesh).structure;
  const tbb::global_control more_threads(tbb::global_control::max_allowed_parallelism, 8);
  const auto one = refit_wide(bvh, target, {.threads = 1});
  for (const int threads : {2, 8}) {
    const auto many = refit_wide(bvh, target, {.threads = threads});
    EXPECT_TRUE(test::same_bytes(one->structure, many->structure));
    EXPECT_EQ(one->costs.after, many->costs.after);
  }
}

TEST(RefitWide, AnotherMeshIsRefused) {
  const TriangleMesh mesh = test::soup(100, 0.3f);
  const Bvh8 bvh = test::build<FastWideBvh>(mesh).structure;
  for (const std::size_t triangles : {99, 101}) {  // one is missing; one is not in the tree
    const auto result = refit_wide(bvh, test::soup(triangles, 0.3f), {});
    ASSERT_FALSE(result);
    EXPECT_NE(result.message().find(triangles == 99 ? "triangle 99" : "triangle 100"), std::string::npos) << result.message();
  }
}

TEST(RefitWide, TrianglesThatCannotBeHitAreRefused) {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), 1e30f}) {
    TriangleMesh mesh = test::soup(100, 0.3f);
    const Bvh8 bvh = test::build<FastWideBvh>(mesh).structure;
    mesh.vertices[3 * 42].y = bad;
    const auto result = refit_wide(bvh, mesh, {});
    ASSERT_FALSE(result);
    EXPECT_NE(result.message().find("triangle 42"), std::string::npos) << result.message();
  }
}

// What was built away is harmless as long as it stays so.
TEST(RefitWide, TrianglesWithoutAreaMustNotGainIt) {
  TriangleMesh mesh = test::soup_with_rejects(500);
  const Bvh8 bvh = test::build<FastWideBvh>(mesh).structure;
  EXPECT_TRUE(refit_wide(bvh, mesh, {}));
  mesh.vertices[1] = mesh.vertices[0] + Vec3{1, 0, 0};
  const auto result = refit_wide(bvh, mesh, {});
  ASSERT_FALSE(result);
  EXPECT_NE(result.message().find("triangle 0"), std::string::npos) << result.message();
}

TEST(RefitWide, NothingStaysNothing) {
  for (const TriangleMesh& mesh : test::empty_meshes()) {
    const auto result = refit_wide(Bvh8{}, mesh, {});
    ASSERT_TRUE(result) << result.message();
    EXPECT_EQ(result->structure.root, kNoNode);
  }
}

}  // namespace
}  // namespace accel
