#include "libaccel/io/load_mesh.h"

#include <zstd.h>

#include <cstring>

#include "libaccel/io/load_scene.h"
#include "validation/unit/io/io_test_support.h"

namespace accel {
namespace {

namespace fs = std::filesystem;

constexpr char kObj[] = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
constexpr char kPly[] =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
    "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";

std::string packed(std::string_view text, int checksum = 1) {
  std::string out(ZSTD_compressBound(text.size()), '\0');
  ZSTD_CCtx* context = ZSTD_createCCtx();
  ZSTD_CCtx_setParameter(context, ZSTD_c_checksumFlag, checksum);
  out.resize(ZSTD_compress2(context, out.data(), out.size(), text.data(), text.size()));
  ZSTD_freeCCtx(context);
  return out;
}

class LoadMeshTest : public FileTest {
 protected:
  void expect_error(const fs::path& path, std::string_view part) const {
    const Result<TriangleMesh> mesh = load_mesh(path);
    ASSERT_FALSE(mesh) << path;
    EXPECT_NE(mesh.message().find(part), std::string::npos) << mesh.message();
    EXPECT_NE(mesh.message().find(path.filename().string()), std::string::npos) << mesh.message();
  }
};

TEST_F(LoadMeshTest, ChoosesByName) {
  for (const fs::path& path : {file("a.obj", kObj), file("A.OBJ", kObj), file("a.ply", kPly), file("a.obj.zst", packed(kObj)),
                               file("a.b.PLY.ZST", packed(kPly, 0))}) {
    EXPECT_TRUE(is_mesh_file_name(path));
    const Result<TriangleMesh> mesh = load_mesh(path);
    ASSERT_TRUE(mesh) << mesh.message();
    EXPECT_EQ(mesh->size(), 2u);
    EXPECT_EQ(mesh->vertices.size(), 4u);
  }
  for (const char* name : {"a.stl", "a.zst", "a.obj.xz", "obj", ".ply"}) {
    EXPECT_FALSE(is_mesh_file_name(name)) << name;
    expect_error(file(name, kObj), "is not named like a scene");
  }
}

TEST_F(LoadMeshTest, MissingFilesAndFolders) {
  expect_error(folder() / "missing.ply", "No such file");
  fs::create_directory(folder() / "folder.ply");
  expect_error(folder() / "folder.ply", "is a folder");
  expect_error(file("empty.ply", ""), "a PLY file begins");
}

TEST_F(LoadMeshTest, SeveralFramesAndMuchData) {
  std::string text = kObj;
  for (int i = 0; i < 300000; ++i) text += "f 1 2 3\n";
  const std::string frames = packed(std::string_view(text).substr(0, 100)) + packed(std::string_view(text).substr(100));
  const Result<TriangleMesh> mesh = load_mesh(file("a.obj.zst", frames));
  ASSERT_TRUE(mesh) << mesh.message();
  EXPECT_EQ(mesh->size(), 300002u);
}

TEST_F(LoadMeshTest, PackedFilesThatAreDamaged) {
  const std::string good = packed(kPly);
  for (std::size_t size = 0; size < good.size(); ++size)
    expect_error(file("short.ply.zst", good.substr(0, size)), "ends early");
  expect_error(file("plain.ply.zst", kPly), "damaged zstd data");
  expect_error(file("tail.ply.zst", good + "tail and more"), "damaged zstd data");
  for (std::size_t i = 0; i < good.size(); ++i) {
    std::string bad = good;
    bad[i] = static_cast<char>(bad[i] ^ 0x55);
    const Result<TriangleMesh> mesh = load_mesh(file("bad.ply.zst", bad));
    EXPECT_TRUE(!mesh || validate(*mesh));
  }
}

TEST_F(LoadMeshTest, ProgressIsTold) {
  double last = -1;
  std::string phase;
  const LoadOptions options{[&](std::string_view name, double fraction) {
    phase = name, last = fraction;
    return true;
  }};
  ASSERT_TRUE(load_mesh(file("a.ply", kPly), options));
  EXPECT_EQ(phase, "read");
  EXPECT_GE(last, 0);
  EXPECT_LE(last, 1);
  EXPECT_EQ(load_mesh(file("b.ply.zst", packed(kPly)), {[](std::string_view, double) { return false; }}).message(),
            kInterrupted);
}

// The project's scenes, where they are present.
class ScenesTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(folder_ / "scenes.tsv")) GTEST_SKIP() << folder_ << " is not here";
  }
  const fs::path folder_ = fs::path(ACCEL_SOURCE_DIR) / ".." / "shared" / "scenes";
};

TEST_F(ScenesTest, CountsOfPackedPly) {
  const std::tuple<const char*, std::size_t, std::size_t, std::size_t> scenes[] = {{"cornell-box", 36, 28, 1},
                                                                                   {"teapot", 2464, 1232, 1},
                                                                                   {"bart-kitchen", 110561, 56546, 2},
                                                                                   {"conference", 331179, 152612, 2}};
  for (const auto& [name, triangles, vertices, cameras] : scenes) {
    const Result<SceneData> scene = load_scene(folder_ / (std::string(name) + ".ply.zst"));
    ASSERT_TRUE(scene) << scene.message();
    EXPECT_EQ(scene->mesh.size(), triangles);
    EXPECT_EQ(scene->mesh.vertices.size(), vertices);
    EXPECT_EQ(scene->cameras.size(), cameras);
    EXPECT_TRUE(validate(scene->mesh));
  }
}

TEST_F(ScenesTest, ObjAsPublished) {
  const std::pair<const char*, std::size_t> files[] = {
      {"CornellBox-Original.obj", 36}, {"cornellBox.obj", 32}, {"cornellbox_suzanne.obj", 980}};
  for (const auto& [name, triangles] : files) {
    const Result<TriangleMesh> mesh = load_mesh(folder_ / "obj" / name);
    ASSERT_TRUE(mesh) << mesh.message();
    EXPECT_EQ(mesh->size(), triangles);
    EXPECT_TRUE(validate(*mesh));
  }
}

// The packed PLY was made from this OBJ: the same triangles in the same order.
TEST_F(ScenesTest, ObjAndPlyAgree) {
  const Result<TriangleMesh> obj = load_mesh(folder_ / "obj" / "CornellBox-Original.obj");
  const Result<TriangleMesh> ply = load_mesh(folder_ / "cornell-box.ply.zst");
  ASSERT_TRUE(obj && ply);
  ASSERT_EQ(obj->size(), ply->size());
  for (std::size_t i = 0; i < obj->size(); ++i) {
    const Triangle a = obj->triangle(i), b = ply->triangle(i);
    EXPECT_TRUE(a.v0 == b.v0 && a.v1 == b.v1 && a.v2 == b.v2) << i;
  }
}

}  // namespace
}  // namespace accel
