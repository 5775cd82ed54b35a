#include "libaccel/geometry/instanced_meshes.h"

#include <gtest/gtest.h>

#include <limits>

#include "libaccel/geometry/mesh_facts.h"
#include "libaccel/geometry/triangle_source.h"
#include "validation/stress/stress_instances.h"
#include "validation/stress/stress_scenes.h"

namespace accel {
namespace {

using validation::mesh_of;
using validation::random_triangles;

std::string complaint(std::vector<TriangleMesh> meshes, std::vector<Instance> instances) {
  const auto scene = InstancedMeshes::make(std::move(meshes), std::move(instances));
  return scene ? "" : scene.message();
}

// A mesh of this many triangles, all the same.
TriangleMesh repeated(std::size_t triangles) {
  TriangleMesh mesh = mesh_of({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}});
  mesh.triangles = Buffer<IndexTriple>(triangles);
  for (IndexTriple& t : mesh.triangles) t = {0, 1, 2};
  return mesh;
}

TEST(InstancedMeshes, NumbersGoOnFromInstanceToInstance) {
  const auto scene = InstancedMeshes::make({repeated(3), repeated(0), repeated(5)},
                                           {{2, {}}, {1, {}}, {0, {}}, {1, {}}, {1, {}}, {2, {}}, {1, {}}});
  ASSERT_TRUE(scene) << scene.message();
  EXPECT_EQ(scene->size(), 13u);
  const std::vector<std::pair<std::uint32_t, std::uint32_t>> expected = {{0, 0}, {0, 1}, {0, 2}, {0, 3}, {0, 4}, {2, 0}, {2, 1},
                                                                         {2, 2}, {5, 0}, {5, 1}, {5, 2}, {5, 3}, {5, 4}};
  for (std::uint32_t prim = 0; prim < expected.size(); ++prim) {
    const auto place = scene->place_of(prim);
    EXPECT_EQ(place.instance, expected[prim].first) << prim;
    EXPECT_EQ(place.triangle, expected[prim].second) << prim;
    EXPECT_EQ(scene->first_prim(place.instance) + place.triangle, prim);
  }
}

TEST(InstancedMeshes, MoreTrianglesThanNumbersAreAnError) {
  const TriangleMesh mesh = repeated(1 << 20);  // 4096 of them are one too many
  EXPECT_EQ(complaint({mesh, repeated((1 << 20) - 1)},
                      [] {
                        std::vector<Instance> all(4095, Instance{0, {}});
                        all.push_back({1, {}});
                        return all;
                      }()),
            "");
  const std::string message = complaint({mesh}, std::vector<Instance>(4096, Instance{0, {}}));
  EXPECT_NE(message.find("instance 4096"), std::string::npos) << message;
}

TEST(InstancedMeshes, BadInstancesAreNamed) {
  const TriangleMesh mesh = mesh_of(random_triangles(5, 0.5f, 1));
  Affine singular, far;
  singular.m[1][1] = 0;
  far.m[0][0] = 1e18f, far.m[0][3] = 1.8e18f;
  for (const auto& bad : {Instance{0, singular}, Instance{0, far}, Instance{1, {}}, Instance{0xffffffffu, {}}}) {
    const std::string message = complaint({mesh}, {Instance{}, bad});
    EXPECT_EQ(message.rfind("instance 2: ", 0), 0u) << message;
  }
  TriangleMesh broken = mesh_of(random_triangles(5, 0.5f, 1));
  broken.triangles[0].v0 = 1000;
  EXPECT_NE(complaint({broken}, {}), "");
}

TEST(InstancedMeshes, OtherInstancesOfTheSameMeshes) {
  const TriangleMesh mesh = validation::mesh_of(validation::random_triangles(7, 0.5f, 1));
  const InstancedMeshes scene = *InstancedMeshes::make({mesh, mesh}, {{0, {}}});
  const auto placed = scene.with_instances({{1, {}}, {0, placed_by({1, 1, 1}, {0, 0, 1}, 0, {5, 0, 0})}});
  ASSERT_TRUE(placed) << placed.message();
  EXPECT_EQ(placed->size(), 14u);
  EXPECT_EQ(placed->first_prim(1), 7u);
  EXPECT_EQ(placed->meshes().data(), scene.meshes().data()) << "nothing is copied";
  EXPECT_EQ(placed->triangle(9).v0, mesh.triangle(2).v0 + Vec3({5, 0, 0}));
  EXPECT_EQ(scene.size(), 7u);
  EXPECT_EQ(placed->flattened()->size(), 14u);

  EXPECT_NE(scene.with_instances({{2, {}}}).message().find("instance 1: is of mesh 3"), std::string::npos);
  Affine singular;
  singular.m[1][1] = 0;
  EXPECT_NE(scene.with_instances({{0, {}}, {0, singular}}).message().find("instance 2: its transform"), std::string::npos);
  EXPECT_EQ(InstancedMeshes().with_instances({})->size(), 0u);
}

TEST(InstancedMeshes, FlattenedIsTriangleByTriangle) {
  for (const auto& s : validation::instanced_scenes()) {
    const auto flat = s.scene.flattened();
    ASSERT_TRUE(flat) << flat.message();
    ASSERT_EQ(flat->size(), s.scene.size()) << s.name;
    EXPECT_TRUE(validate(*flat)) << s.name;
    const TriangleSource source(s.scene);
    for (std::uint32_t i = 0; i < flat->size(); ++i) {
      const Triangle a = flat->triangle(i), b = source.triangle(i);
      ASSERT_TRUE(a.v0 == b.v0 && a.v1 == b.v1 && a.v2 == b.v2) << s.name << ' ' << i;
    }
    EXPECT_EQ(s.scene.flattened()->vertices.data(), flat->vertices.data()) << "made once";
  }
}

// The one instance of a mesh at its place is the mesh.
TEST(InstancedMeshes, IdentityKeepsVertices) {
  const TriangleMesh mesh = mesh_of(random_triangles(50, 0.5f, 2));
  const auto flat = InstancedMeshes::make({mesh}, {Instance{}})->flattened();
  for (std::uint32_t i = 0; i < mesh.vertices.size(); ++i) EXPECT_EQ(flat->vertices[i], mesh.vertices[i]);
}

TEST(InstancedMeshes, FactsAreThoseOfAllTriangles) {
  for (const auto& s : validation::instanced_scenes()) {
    const MeshFacts facts = mesh_facts(s.scene), flat = mesh_facts(*s.scene.flattened());
    EXPECT_EQ(facts.triangles, s.scene.size());
    EXPECT_EQ(facts.zero_area, flat.zero_area);
    EXPECT_EQ(facts.bounds.lo, flat.bounds.lo);
    EXPECT_EQ(facts.bounds.hi, flat.bounds.hi);
  }
}

TEST(InstancedMeshes, LargeScenesOfCopiesAreBetterApart) {
  EXPECT_TRUE(are_better_apart(kLargeMesh, 1));
  EXPECT_FALSE(are_better_apart(kLargeMesh - 1, 1)) << "one mesh is not large";
  EXPECT_FALSE(are_better_apart(kLargeMesh, kLargeMesh)) << "no copies";
  EXPECT_FALSE(are_better_apart(kMostlyCopies * kLargeMesh, kLargeMesh));
  EXPECT_TRUE(are_better_apart(kMostlyCopies * kLargeMesh + 1, kLargeMesh));
}

}  // namespace
}  // namespace accel
