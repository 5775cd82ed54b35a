#include "libaccel/io/load_scene.h"

#include "validation/unit/io/io_test_support.h"

namespace accel {
namespace {

constexpr const char* kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
constexpr const char* kSquare = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";

class LoadSceneTest : public FileTest {};

TEST_F(LoadSceneTest, AMeshWithoutADescription) {
  const auto scene = load_scene(file("a.obj", kSquare));
  ASSERT_TRUE(scene) << scene.message();
  EXPECT_FALSE(scene->instances);
  EXPECT_EQ(scene->triangles().size(), 2u);
  EXPECT_EQ(scene->one_mesh()->size(), 2u);
}

TEST_F(LoadSceneTest, InstancesOfTheSceneAndOfOtherFiles) {
  std::filesystem::create_directories(folder() / "parts");
  file("parts/b.obj", kTriangle);
  file("a.json", R"({"instances": [{"mesh": "parts/b.obj"}, {}, {"mesh": "./a.obj", "translate": [5, 0, 0]},
      {"mesh": "parts/../parts/b.obj", "scale": -1}]})");
  const auto scene = load_scene(file("a.obj", kSquare));
  ASSERT_TRUE(scene) << scene.message();
  ASSERT_TRUE(scene->instances);
  EXPECT_EQ(scene->instances->meshes().size(), 2u) << "each file is loaded once";
  EXPECT_EQ(scene->triangles().size(), 1u + 2 + 2 + 1);
  EXPECT_EQ(scene->triangles().triangle(3).v0, (Vec3{5, 0, 0}));
  EXPECT_EQ(scene->triangles().triangle(5).v1, (Vec3{-1, 0, 0}));
  EXPECT_EQ(scene->one_mesh()->size(), 6u);
}

// What stands beside an instance's mesh is not read, so that a scene cannot contain itself.
TEST_F(LoadSceneTest, DescriptionsOfMeshesAreNotFollowed) {
  file("a.json", R"({"instances": [{"mesh": "b.obj"}, {"mesh": "b.obj", "translate": [2, 0, 0]}]})");
  file("b.obj", kTriangle);
  file("b.json", R"({"instances": [{"mesh": "a.obj"}, {"mesh": "b.obj"}, {"mesh": "nowhere.obj"}]})");
  const auto scene = load_scene(file("a.obj", kSquare));
  ASSERT_TRUE(scene) << scene.message();
  EXPECT_EQ(scene->triangles().size(), 2u);
}

TEST_F(LoadSceneTest, MistakesNameTheDescriptionAndTheInstance) {
  const auto message = [&](const std::string& list) {
    const std::string description = file("a.json", R"({"instances": )" + list + "}").string();
    const auto scene = load_scene(file("a.obj", kSquare));
    EXPECT_FALSE(scene) << list;
    if (scene) return std::string();
    EXPECT_EQ(scene.message().rfind(description, 0), 0u) << scene.message();
    return scene.message();
  };
  EXPECT_NE(message(R"([{}, {"mesh": "none.obj"}])").find("instance 2: "), std::string::npos);
  EXPECT_NE(message(R"([{}, {"mesh": "."}])").find("instance 2: "), std::string::npos);
  EXPECT_NE(message(R"([{"mesh": "a.json"}])").find("instance 1: "), std::string::npos);
  EXPECT_NE(message(R"([{}, {}, {"scale": 1e18, "translate": [1.8e18, 0, 0]}])").find("instance 3: "), std::string::npos);
  EXPECT_NE(message(R"([{"transform": [1, 2]}])").find("instance 1: "), std::string::npos);
}

TEST_F(LoadSceneTest, NoInstancesAreAnEmptyScene) {
  file("a.json", R"({"instances": []})");
  const auto scene = load_scene(file("a.obj", kSquare));
  ASSERT_TRUE(scene) << scene.message();
  EXPECT_EQ(scene->triangles().size(), 0u);
}

}  // namespace
}  // namespace accel
