#include "validation/stress/stress_geometry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <tuple>

#include "libaccel/build/kdtree_sah.h"
#include "libaccel/build/sbvh.h"
#include "libaccel/geometry/mesh_facts.h"
#include "validation/oracle/exact_predicates.h"
#include "validation/stress/closed_meshes.h"

namespace accel::validation {
namespace {

constexpr SceneSize kSmall = SceneSize::small;

// The longest edge over the height on it.
double aspect(const Triangle& t) {
  const Vec3d a = Vec3d(t.v1) - Vec3d(t.v0), b = Vec3d(t.v2) - Vec3d(t.v1), c = Vec3d(t.v0) - Vec3d(t.v2);
  const double longest = std::max({length(a), length(b), length(c)});
  return longest * longest / length(cross(a, b));
}

TEST(StressGeometry, SliversAndNeedlesAreThin) {
  for (const SceneMaker maker : {sliver_scenes, needle_scenes}) {
    const TriangleMesh mesh = maker(kSmall, 1)[0].mesh;
    std::vector<double> aspects;
    for (std::size_t i = 0; i < mesh.size(); ++i) aspects.push_back(aspect(mesh.triangle(i)));
    std::nth_element(aspects.begin(), aspects.begin() + static_cast<long>(aspects.size() / 2), aspects.end());
    EXPECT_GT(aspects[aspects.size() / 2], 5e6);
  }
}

TEST(StressGeometry, ZeroAreaIsExact) {
  for (const StressScene& scene : zero_area_scenes(kSmall, 1)) {
    for (std::size_t i = 0; i < scene.mesh.size(); ++i) EXPECT_TRUE(has_zero_area(scene.mesh.triangle(i))) << scene.name;
    EXPECT_EQ(mesh_facts(scene.mesh).zero_area, scene.mesh.size()) << scene.name;
  }
}

TEST(StressGeometry, CentroidsAreOne) {
  const TriangleMesh mesh = one_centroid(kSmall, 1)[0].mesh;
  for (std::size_t i = 0; i < mesh.size(); ++i) {
    const Vec3 center = mesh.triangle(i).bounds().center();
    EXPECT_TRUE(center.x == 1 && center.y == 2 && center.z == 3) << i;
  }
}

TEST(StressGeometry, CopiesAreFound) {
  EXPECT_EQ(without_copies(one_many_times(kSmall, 1)[0].mesh).size(), 1u);
  EXPECT_EQ(without_copies(few_many_times(kSmall, 1)[0].mesh).size(), 100u);
}

TEST(StressGeometry, TreesAreDeep) {
  std::uint32_t deepest = 0;
  for (const StressScene& scene : deep_trees(kSmall, 1)) {
    const auto built = Sbvh::build(scene.mesh, {.max_leaf_size = 1});
    ASSERT_TRUE(built) << built.message();
    EXPECT_GT(built->structure.depth, 30u) << scene.name;
    deepest = std::max(deepest, built->structure.depth);
  }
  EXPECT_GT(deepest, 64u);
}

// What these slivers are for: without a budget spatial splits would go on and on. With it, references keep to the limit
// exactly.
TEST(StressGeometry, DiagonalSliversExhaustTheBudget) {
  const TriangleMesh mesh = diagonal_slivers(kSmall, 1)[0].mesh;
  const auto triangles = static_cast<double>(mesh.size());
  for (const float budget : {0.0f, 0.5f, 3.0f}) {
    const auto built = Sbvh::build(mesh, {.max_duplication = budget});
    ASSERT_TRUE(built) << built.message();
    EXPECT_LE(static_cast<double>(built->report.references), (1 + double{budget}) * triangles);
    EXPECT_GE(static_cast<double>(built->report.references), (1 + 0.6 * double{budget}) * triangles)
        << "the scene tests nothing";
  }
  for (const float budget : {1.0f, 4.0f}) {
    const auto built = KdTreeSah::build(mesh, {.max_references = budget});
    ASSERT_TRUE(built) << built.message();
    EXPECT_LE(static_cast<double>(built->report.references), double{budget} * triangles);
  }
}

TEST(StressGeometry, BrokenCoordinatesAreBroken) {
  const std::vector<StressScene> scenes = broken_coordinates(kSmall, 1);
  EXPECT_EQ(mesh_facts(scenes[0].mesh).out_of_range, 100u);
  EXPECT_EQ(mesh_facts(scenes[1].mesh).out_of_range, scenes[1].mesh.size());
  EXPECT_FALSE(validate(broken_indices(kSmall, 1)[0].mesh));
}

// Each edge belongs to two triangles, which run along it in opposite directions.
TEST(ClosedMeshes, AreClosed) {
  for (const ClosedMesh& closed : closed_meshes(2000, 3)) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    for (const IndexTriple& t : closed.mesh.triangles) ++edges[{t.v0, t.v1}], ++edges[{t.v1, t.v2}], ++edges[{t.v2, t.v0}];
    for (const auto& [edge, times] : edges) {
      EXPECT_EQ(times, 1) << closed.name;
      EXPECT_TRUE(edges.contains({edge.second, edge.first})) << closed.name;
    }
    EXPECT_EQ(mesh_facts(closed.mesh).zero_area, 0u) << closed.name;
  }
}

// The solid angle that the mesh covers, seen from a point, in spheres: by the formula of van Oosterom and Strackee.
double winding(const TriangleMesh& mesh, Vec3d from) {
  double sum = 0;
  for (std::size_t i = 0; i < mesh.size(); ++i) {
    const Triangle t = mesh.triangle(i);
    const Vec3d a = Vec3d(t.v0) - from, b = Vec3d(t.v1) - from, c = Vec3d(t.v2) - from;
    const double la = length(a), lb = length(b), lc = length(c);
    sum += std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
  }
  return sum / (2 * std::numbers::pi);
}

TEST(ClosedMeshes, KnowTheirInside) {
  for (const ClosedMesh& closed : closed_meshes(2000, 3))
    for (const double offset : {0.0, 1e4, 1e6}) {
      const Placement placement{1, offset};
      const TriangleMesh mesh = placed(closed.mesh, placement);
      CounterRng rng(4, 0);
      for (int i = 0; i < 10; ++i) {
        EXPECT_NEAR(std::abs(winding(mesh, Vec3d(placement(closed.inside(rng)).to_float()))), 1, 1e-6) << closed.name << offset;
        EXPECT_NEAR(winding(mesh, Vec3d(placement(closed.outside(rng)).to_float())), 0, 1e-6) << closed.name << offset;
      }
    }
}

// Up to 1e4 times their size away the vertices of meshes of some ten thousand triangles stay apart, and no triangle loses its
// area: what the absence of leaks there rests on.
TEST(ClosedMeshes, KeepTheirVerticesApart) {
  for (const ClosedMesh& closed : closed_meshes(10'000, 3))
    for (const double scale : {1e-3, 1.0, 1e3}) {
      const TriangleMesh mesh = placed(closed.mesh, {scale, 1e4});
      std::set<std::tuple<float, float, float>> positions;
      for (const Vec3& v : mesh.vertices) positions.insert({v.x, v.y, v.z});
      EXPECT_EQ(positions.size(), mesh.vertices.size()) << closed.name;
      EXPECT_EQ(mesh_facts(mesh).zero_area, 0u) << closed.name;
    }
}

}  // namespace
}  // namespace accel::validation
