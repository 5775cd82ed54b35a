#include "scenes/procedural.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <cstring>
#include <map>
#include <string>
#include <utility>

#include "libaccel/build/binned_sah.h"
#include "libaccel/geometry/mesh_facts.h"
#include "libaccel/rays/camera.h"

namespace accel {
namespace {

SceneData make(std::string_view name, std::uint64_t size, std::uint64_t seed = 1) {
  auto scene = make_builtin(std::string(name) + ":" + std::to_string(size), seed);
  EXPECT_TRUE(scene.ok()) << name;
  return std::move(scene).value();
}

bool same_bytes(const TriangleMesh& a, const TriangleMesh& b) {
  return a.size() == b.size() && a.vertices.size() == b.vertices.size() &&
         std::memcmp(a.vertices.data(), b.vertices.data(), a.vertices.size_bytes()) == 0 &&
         std::memcmp(a.triangles.data(), b.triangles.data(), a.triangles.size_bytes()) == 0;
}

// How often each undirected edge is used.
std::map<std::pair<std::uint32_t, std::uint32_t>, int> edge_uses(const TriangleMesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> uses;
  for (const IndexTriple& t : mesh.triangles)
    for (const auto& [a, b] : {std::pair{t.v0, t.v1}, {t.v1, t.v2}, {t.v2, t.v0}}) ++uses[std::minmax(a, b)];
  return uses;
}

TEST(Builtin, StadiumComesFirst) { EXPECT_EQ(builtin_scenes().front().name, "stadium"); }

TEST(Builtin, SizesAreNearTheAskedOnes) {
  for (const BuiltinScene& scene : builtin_scenes()) {
    for (const double size : {30'000.0, 200'000.0}) {
      const auto triangles = static_cast<double>(make(scene.name, static_cast<std::uint64_t>(size)).triangles().size());
      EXPECT_NEAR(triangles / size, 1, 0.1) << scene.name << ' ' << size;
    }
    EXPECT_NEAR(
        static_cast<double>(make(scene.name, scene.default_size).triangles().size()) / static_cast<double>(scene.default_size),
        1, 0.1)
        << scene.name;
  }
}

TEST(Builtin, EveryTriangleCanBeHit) {
  for (const BuiltinScene& scene : builtin_scenes()) {
    for (const std::uint64_t size : {1u, 100u, 5'000u, 50'000u}) {
      const SceneData data = make(scene.name, size);
      ASSERT_GT(data.triangles().size(), 0u) << scene.name;
      ASSERT_TRUE(validate(*data.one_mesh()).ok()) << scene.name;
      const MeshFacts facts = mesh_facts(data.triangles());
      EXPECT_EQ(facts.out_of_range, 0u) << scene.name << ' ' << size;
      EXPECT_EQ(facts.zero_area, 0u) << scene.name << ' ' << size;
    }
  }
}

TEST(Builtin, CamerasAreUsable) {
  for (const BuiltinScene& scene : builtin_scenes()) {
    const SceneData data = make(scene.name, 1000);
    ASSERT_FALSE(data.cameras.empty()) << scene.name;
    for (const CameraDescription& camera : data.cameras) EXPECT_TRUE(Camera::make(camera, 16, 9).ok()) << scene.name;
  }
}

TEST(Builtin, DoesNotDependOnThreads) {
  for (const BuiltinScene& scene : builtin_scenes()) {
    const auto with_threads = [&](std::size_t threads) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      return *make(scene.name, 40'000).one_mesh();
    };
    EXPECT_TRUE(same_bytes(with_threads(1), with_threads(4))) << scene.name;
  }
}

TEST(Builtin, DependsOnTheSeedWhereItIsRandom) {
  for (const std::string_view name : {"stadium", "soup", "slivers", "terrain", "hairball", "spheres", "deep", "forest"}) {
    EXPECT_TRUE(same_bytes(*make(name, 20'000, 3).one_mesh(), *make(name, 20'000, 3).one_mesh())) << name;
    EXPECT_FALSE(same_bytes(*make(name, 20'000, 3).one_mesh(), *make(name, 20'000, 4).one_mesh())) << name;
  }
}

TEST(Builtin, SpecsAreReadAsDocumented) {
  const auto count = [](std::string_view spec) { return make_builtin(spec).value().mesh.size(); };
  EXPECT_EQ(count("soup:1234"), 1234u);
  EXPECT_EQ(count("builtin:soup:2k"), 2000u);
  EXPECT_EQ(count("soup:1.5K"), 1500u);
  EXPECT_EQ(count("soup:0.01M"), 10000u);
  EXPECT_EQ(count("cornell"), 32u);
}

TEST(Builtin, BadSpecsAreErrors) {
  EXPECT_EQ(make_builtin("stadum").message(), "unknown builtin scene 'stadum'; did you mean 'stadium'?");
  EXPECT_NE(make_builtin("").message().find("known are stadium"), std::string::npos);
  for (const char* size : {"", "k", "abc", "12x", "1kk", "nan", "inf", "0x10"})
    EXPECT_FALSE(make_builtin("soup:" + std::string(size)).ok()) << size;
  for (const char* size : {"0", "-5", "0.2", "1e30", "300M"})
    EXPECT_NE(make_builtin("soup:" + std::string(size)).message().find("out of range"), std::string::npos) << size;
}

TEST(Spheres, AreClosed) {
  for (const auto& [edge, uses] : edge_uses(make("spheres", 20'000).mesh)) ASSERT_EQ(uses, 2);
}

TEST(Terrain, IsOneSheetWithABorder) {
  const TriangleMesh mesh = make("terrain", 20'000).mesh;
  const auto side = static_cast<std::size_t>(std::lround(std::sqrt(static_cast<double>(mesh.size()) / 2)));
  std::size_t border = 0;
  for (const auto& [edge, uses] : edge_uses(mesh)) {
    ASSERT_TRUE(uses == 1 || uses == 2);
    border += uses == 1;
  }
  EXPECT_EQ(border, 4 * side) << "every inner edge has two triangles";
}

TEST(Slivers, ReachAMillionToOne) {
  double thinnest = 1;
  const TriangleMesh mesh = make("slivers", 50'000).mesh;
  for (std::size_t i = 0; i < mesh.size(); ++i) {
    const Triangle t = mesh.triangle(i);
    const Vec3d base = Vec3d(t.v1) - Vec3d(t.v0);
    thinnest = std::fmin(thinnest, length(cross(base, Vec3d(t.v2) - Vec3d(t.v0))) / dot(base, base));
  }
  EXPECT_LT(thinnest, 3e-6);
}

TEST(Deep, DrivesASurfaceAreaBuilderBelow64Levels) {
  const auto built = BinnedSah::build(make("deep", 20'000).mesh, {});
  ASSERT_TRUE(built.ok());
  EXPECT_GT(built->structure.depth, 64u);
}

}  // namespace
}  // namespace accel
