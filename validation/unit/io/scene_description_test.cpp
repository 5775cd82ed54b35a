#include "libaccel/io/scene_description.h"

#include <cmath>
#include <limits>

#include "validation/unit/io/io_test_support.h"

namespace accel {
namespace {

class SceneDescriptionTest : public FileTest {
 protected:
  static void expect_error(std::string_view json, std::string_view part) {
    const Result<SceneDescription> scene = parse_scene_json(json, "s.json");
    ASSERT_FALSE(scene) << json;
    EXPECT_NE(scene.message().find(part), std::string::npos) << scene.message();
    EXPECT_EQ(scene.message().rfind("s.json", 0), 0u) << scene.message();
  }
};

constexpr char kTable[] =
    "#name\tfile\ttriangles\teye\tat\tup\tvfov_deg\n"
    "room\troom.ply\t3\t1 2 3\t4 5 6\t0 1 0\t60\n"
    "room#2\troom.ply\t3\t-1 2e1 .5\t0 0 0\t0 0 1\t30.5\n"
    "other\tother.ply\t3\tbroken\t0 0 0\t0 0 1\t30\n";

TEST_F(SceneDescriptionTest, CamerasAndLight) {
  const auto scene = parse_scene_json(
      R"({"cameras": [{"eye": [1, 2, 3], "at": [4, 5, 6]},
                      {"name": "door", "eye": [0, 0, 1], "at": [0, 0, 0], "up": [1, 0, 0], "vfov": 30.5}],
          "light": {"corner": [0, 4, 0], "edge_u": [2, 0, 0], "edge_v": [0, 0, 4]}})",
      "s.json");
  ASSERT_TRUE(scene) << scene.message();
  ASSERT_EQ(scene->cameras.size(), 2u);
  EXPECT_EQ(scene->cameras[0].name, "camera 1");
  EXPECT_EQ(scene->cameras[0].eye, (Vec3{1, 2, 3}));
  EXPECT_EQ(scene->cameras[0].at, (Vec3{4, 5, 6}));
  EXPECT_EQ(scene->cameras[0].up, (Vec3{0, 1, 0}));
  EXPECT_EQ(scene->cameras[0].vfov_degrees, 45);
  EXPECT_EQ(scene->cameras[1].name, "door");
  EXPECT_EQ(scene->cameras[1].vfov_degrees, 30.5f);
  ASSERT_TRUE(scene->light);
  EXPECT_EQ(scene->light->center, (Vec3{1, 4, 2}));
  EXPECT_EQ(scene->light->half_u, (Vec3{1, 0, 0}));
  EXPECT_EQ(scene->light->half_v, (Vec3{0, 0, 2}));
}

TEST_F(SceneDescriptionTest, OtherFormsOfLight) {
  const auto center =
      parse_scene_json(R"({"light": {"center": [1, 2, 3], "half_u": [1, 0, 0], "half_v": [0, 1, 0]}})", "s.json");
  ASSERT_TRUE(center) << center.message();
  EXPECT_EQ(center->light->center, (Vec3{1, 2, 3}));
  const auto point = parse_scene_json(R"({"light": {"point": [1, 2, 3]}})", "s.json");
  ASSERT_TRUE(point) << point.message();
  EXPECT_EQ(point->light->center, (Vec3{1, 2, 3}));
  EXPECT_EQ(point->light->half_u, (Vec3{}));
  EXPECT_TRUE(parse_scene_json("{}", "s.json"));
}

TEST_F(SceneDescriptionTest, Errors) {
  expect_error("", "s.json:1: is not valid JSON");
  expect_error("{\n\n\"cameras\": [}", "s.json:3: is not valid JSON");
  expect_error("[]", "must be an object");
  expect_error(R"({"camera": []})", "cameras");
  expect_error(R"({"cameras": {}})", "must be a list");
  expect_error(R"({"cameras": [7]})", "camera 1: must be an object");
  expect_error(R"({"cameras": [{"at": [0, 0, 0]}]})", "camera 1: eye is missing");
  expect_error(R"({"cameras": [{"eye": [0, 0], "at": [0, 0, 0]}]})", "eye must be three numbers");
  expect_error(R"({"cameras": [{"eye": [0, 0, "x"], "at": [0, 0, 0]}]})", "eye must be three numbers");
  expect_error(R"({"cameras": [{"eye": [0, 0, 1e300], "at": [0, 0, 0]}]})", "eye must be three numbers");
  expect_error(R"({"cameras": [{"eye": [0, 0, 1e999], "at": [0, 0, 0]}]})", "too large");
  expect_error(R"({"cameras": [{"eye": [0, 0, 1], "at": [0, 0, 0], "vfov": 180}]})", "vfov must lie between");
  expect_error(R"({"cameras": [{"eye": [0, 0, 1], "at": [0, 0, 0], "vfov": "wide"}]})", "vfov must be a number");
  expect_error(R"({"cameras": [{"eye": [0, 0, 1], "at": [0, 0, 0], "fov": 60}]})", "vfov");
  expect_error(R"({"cameras": [{"eye": [0, 0, 1], "at": [0, 0, 0], "name": 3}]})", "name must be a string");
  expect_error(R"({"cameras": [{"eye": [1, 1, 1], "at": [1, 1, 1]}]})", "the same point");
  expect_error(R"({"cameras": [{"eye": [0, 1, 0], "at": [0, 0, 0]}]})", "along the view direction");
  expect_error(R"({"light": {}})", "light: needs one of");
  expect_error(R"({"light": {"point": [0, 0, 0], "half_u": [1, 0, 0]}})", "light:");
  expect_error(R"({"light": {"corner": [0, 0, 0], "edge_u": [1, 0, 0], "half_v": [1, 0, 0]}})", "edge_v is missing");
  expect_error(std::string(100000, '['), "is not valid JSON");
}

TEST_F(SceneDescriptionTest, Tables) {
  const auto scene = parse_scene_table(kTable, "scenes.tsv", "room.ply");
  ASSERT_TRUE(scene) << scene.message();
  ASSERT_EQ(scene->cameras.size(), 2u);
  EXPECT_EQ(scene->cameras[0].name, "room");
  EXPECT_EQ(scene->cameras[1].name, "room#2");
  EXPECT_EQ(scene->cameras[1].eye, (Vec3{-1, 20, 0.5f}));
  EXPECT_EQ(scene->cameras[1].vfov_degrees, 30.5f);

  const auto broken = parse_scene_table(kTable, "scenes.tsv", "other.ply");
  ASSERT_FALSE(broken);
  EXPECT_EQ(broken.message().rfind("scenes.tsv:4: ", 0), 0u) << broken.message();
  EXPECT_FALSE(parse_scene_table("", "scenes.tsv", "room.ply"));
  EXPECT_FALSE(parse_scene_table("#name\tfile\n", "scenes.tsv", "room.ply"));
  EXPECT_FALSE(parse_scene_table("#name\tfile\teye\tat\tup\tvfov_deg\nroom\n", "scenes.tsv", "room.ply"));
}

TEST_F(SceneDescriptionTest, OrderOfLookUp) {
  const std::filesystem::path scene = folder() / "room.ply.zst";
  const auto name_of = [&] {
    const auto found = find_scene_description(scene);
    EXPECT_TRUE(found) << found.message();
    return found->cameras.empty() ? std::string("none") : found->cameras[0].name;
  };
  const auto json = [](const std::string& name) {
    return R"({"cameras": [{"name": ")" + name + R"(", "eye": [0, 0, 1], "at": [0, 0, 0]}]})";
  };
  EXPECT_EQ(name_of(), "none");
  EXPECT_TRUE(find_scene_description(scene)->source.empty());
  file("scenes.tsv", kTable);
  EXPECT_EQ(name_of(), "none");
  file("scenes.tsv", "#file\tname\tup\tat\teye\tvfov_deg\r\nroom.ply.zst\ttable\t0 1 0\t0 0 0\t0 0 1\t45\r\n");
  EXPECT_EQ(name_of(), "table");
  file("room.json", json("short"));
  EXPECT_EQ(name_of(), "short");
  file("room.ply.zst.json", json("long"));
  EXPECT_EQ(name_of(), "long");
  EXPECT_EQ(find_scene_description(scene)->source.filename(), "room.ply.zst.json");
}

Result<SceneDescription> instances_of(const std::string& list) {
  return parse_scene_json(R"({"instances": )" + list + "}", "forest.json");
}

TEST_F(SceneDescriptionTest, InstancesByTransformOrByParts) {
  const auto scene = instances_of(R"([{"mesh": "a/tree.ply", "transform": [1, 2, 0, 4, 5, 6, 7, 8, 0, 0, -1, 0.5]}, {},
      {"scale": 2, "translate": [1, 2, 3]}, {"scale": [1, -1, 3], "rotate": [0, 5, 0, 90]}])");
  ASSERT_TRUE(scene) << scene.message();
  ASSERT_TRUE(scene->instances);
  const auto& list = *scene->instances;
  ASSERT_EQ(list.size(), 4u);
  EXPECT_EQ(list[0].mesh, "a/tree.ply");
  EXPECT_EQ(list[0].transform, (Affine{{{1, 2, 0, 4}, {5, 6, 7, 8}, {0, 0, -1, 0.5f}}}));
  EXPECT_TRUE(list[1].mesh.empty());
  EXPECT_EQ(list[1].transform, Affine{});
  EXPECT_EQ(list[2].transform, (Affine{{{2, 0, 0, 1}, {0, 2, 0, 2}, {0, 0, 2, 3}}}));
  // First stretched, then turned: x goes to -z, the stretched z to x.
  const Vec3d p = transform_point(list[3].transform, {1, 1, 1});
  EXPECT_NEAR(p.x, 3, 1e-6);
  EXPECT_NEAR(p.y, -1, 1e-6);
  EXPECT_NEAR(p.z, -1, 1e-6);
  EXPECT_FALSE(parse_scene_json("{}", "forest.json")->instances);
}

TEST_F(SceneDescriptionTest, BadInstancesAreNamed) {
  for (const char* bad : {R"({"transform": [1, 2, 3]})",
                          R"({"transform": [1,0,0,0, 0,1,0,0, 0,0,1,0, 5]})",
                          R"({"transform": 1})",
                          R"({"transform": [1,0,0,0, 0,1,0,0, 0,0,"1",0]})",
                          R"({"transform": [1,0,0,0, 0,1,0,0, 0,0,1,null]})",
                          R"({"transform": [1,0,0,0, 0,1,0,0, 0,0,1,1e39]})",
                          R"({"transform": [1,0,0,0, 0,0,0,0, 0,0,1,0]})",
                          R"({"scale": 0})",
                          R"({"scale": [1, 2]})",
                          R"({"scale": "2"})",
                          R"({"scale": 1e39})",
                          R"({"rotate": [0, 0, 0, 90]})",
                          R"({"rotate": [0, 1, 0]})",
                          R"({"translate": [1, 2]})",
                          R"({"translate": {"x": 1}})",
                          R"({"mesh": 7})",
                          R"({"mehs": "a.ply"})",
                          R"({"scale": 2, "transform": [1,0,0,0, 0,1,0,0, 0,0,1,0]})",
                          "[]",
                          "3"}) {
    const auto scene = instances_of("[{}, " + std::string(bad) + "]");
    ASSERT_FALSE(scene) << bad;
    EXPECT_EQ(scene.message().rfind("forest.json: instance 2: ", 0), 0u) << scene.message();
  }
  EXPECT_EQ(instances_of("{}").message(), "forest.json: instances: must be a list in brackets");
}

TEST_F(SceneDescriptionTest, CamerasAtTheLimits) {
  const float large = std::numeric_limits<float>::max(), tiny = std::numeric_limits<float>::denorm_min();
  EXPECT_TRUE(validate(CameraDescription{{large, 0, 0}, {-large, 0, 0}, {0, tiny, 0}}));
  EXPECT_FALSE(validate(CameraDescription{{NAN, 0, 0}, {0, 0, 0}, {0, 1, 0}}));
  EXPECT_FALSE(validate(CameraDescription{{1, 0, 0}, {0, 0, 0}, {0, 1, 0}, NAN}));
  EXPECT_FALSE(validate(CameraDescription{{1, 0, 0}, {0, 0, 0}, {0, 0, 0}}));
}

}  // namespace
}  // namespace accel
