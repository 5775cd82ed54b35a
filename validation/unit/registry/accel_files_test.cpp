#include "libaccel/registry/accel_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <vector>

#include "libaccel/registry/refit.h"
#include "validation/stress/stress_rays.h"
#include "validation/stress/stress_scenes.h"
#include "validation/unit/io/io_test_support.h"

namespace accel {
namespace {

using testing::HasSubstr;

class AccelFilesTest : public FileTest {
 protected:
  std::filesystem::path path() const { return folder() / "a.accel"; }
};

std::vector<Hit> hits_of(const AnyAccel& accel, const std::vector<Ray>& rays) {
  std::vector<Hit> hits(rays.size());
  EXPECT_TRUE(accel.closest(rays, hits));
  return hits;
}
bool same(const std::vector<Hit>& a, const std::vector<Hit>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Hit)) == 0;
}

// A mesh with a triangle that no ray hits.
TriangleMesh mesh_with_a_point() {
  auto triangles = validation::random_triangles(60, 0.5f, 3);
  triangles[7].v1 = triangles[7].v2 = triangles[7].v0;
  return validation::mesh_of(triangles);
}

TEST_F(AccelFilesTest, EveryMethodsStructureComesBack) {
  const TriangleMesh mesh = mesh_with_a_point();
  const std::vector<Ray> rays = validation::stress_rays(mesh, 100);
  for (const MethodInfo& method : methods()) {
    const AnyAccel built = AnyAccel::build(mesh, method.name).value();
    const InstancedMeshes scene = InstancedMeshes::make({mesh}, {Instance{}}).value();
    ASSERT_TRUE(method.instances ? save_accel(path(), built, scene) : save_accel(path(), built, mesh));
    const auto loaded = load_accel(path(), method.name);
    ASSERT_TRUE(loaded) << loaded.message();
    EXPECT_TRUE(same(hits_of(*loaded, rays), hits_of(built, rays))) << method.name;
    EXPECT_EQ(loaded->report().triangles, built.report().triangles);
    EXPECT_EQ(loaded->report().skipped.zero_area, built.report().skipped.zero_area);
    const auto best = load_accel(path());
    ASSERT_TRUE(best) << best.message();
    EXPECT_EQ(best->method().structure, method.structure);
    EXPECT_EQ(best->method().builder, method.builder);
  }
}

// Methods that do not keep instances apart store one mesh.
TEST_F(AccelFilesTest, InstancesAreStoredAsTheMethodHasThem) {
  const InstancedMeshes scene = InstancedMeshes::make({mesh_with_a_point()}, {Instance{}, Instance{}}).value();
  for (const char* method : {"bvh8-instances/stream", "bvh8/stream"}) {
    const AnyAccel built = AnyAccel::build(scene, method).value();
    ASSERT_TRUE(save_accel(path(), built, scene, {.scene = "mine"}));
    const auto file = AccelFile::open(path());
    ASSERT_TRUE(file) << file.message();
    EXPECT_EQ(has_instances(*file), built.method().instances);
    EXPECT_EQ(triangle_count(*file), scene.size());
    const auto metadata = read<AccelMetadata>(*file);
    ASSERT_TRUE(metadata) << metadata.message();
    EXPECT_EQ(metadata->scene, "mine");
    EXPECT_EQ(metadata->builder, built.method().builder);
    EXPECT_EQ(load_accel(path())->method().name, method);
  }
}

// A structure that names triangles which the scene has not would be refused by whoever reads it.
TEST_F(AccelFilesTest, OtherScenesAreRefused) {
  const TriangleMesh mesh = mesh_with_a_point();
  const TriangleMesh other = validation::mesh_of(validation::random_triangles(20, 0.5f, 3));
  for (const char* method : {"bvh8/stream", "kdtree/stack", "grid/dda", "sbvh/hash"}) {
    const Status saved = save_accel(path(), AnyAccel::build(mesh, method).value(), other);
    ASSERT_FALSE(saved) << method;
    EXPECT_THAT(saved.message(), HasSubstr("not of this scene"));
    EXPECT_EQ(files_in_folder(), 0u);
  }
}

// The report that comes with it knows what the build has left out.
TEST_F(AccelFilesTest, WhatWasStoredCanBeRefitted) {
  const TriangleMesh mesh = mesh_with_a_point();
  ASSERT_TRUE(save_accel(path(), AnyAccel::build(mesh, "bvh8/ordered").value(), mesh));
  const auto refitted = refit(load_accel(path()).value(), mesh);
  EXPECT_TRUE(refitted) << refitted.message();
}

TEST_F(AccelFilesTest, WhatIsNotThereOrOfNoKindIsAnError) {
  EXPECT_THAT(load_accel(folder() / "none.accel").message(), HasSubstr("none.accel"));
  const TriangleMesh mesh = mesh_with_a_point();
  ASSERT_TRUE(save_accel(path(), AnyAccel::build(mesh, "kdtree/stack").value(), mesh));
  EXPECT_THAT(load_accel(path(), "bvh8/stream").message(), HasSubstr("'kdtree'"));
  EXPECT_THAT(load_accel(path(), "nonsense").message(), HasSubstr("nonsense"));
  const auto file = AccelFile::open(path());
  ASSERT_TRUE(file) << file.message();
  EXPECT_THAT(read_structure(*file, {.structure = "octree"}).message(), HasSubstr("unknown kind 'octree'"));
}

}  // namespace
}  // namespace accel
