#include "libaccel/io/gltf.h"

#include <cmath>
#include <numbers>
#include <vector>

#include "libaccel/io/load_scene.h"
#include "validation/unit/io/io_test_support.h"

namespace accel {
namespace {

template <class T>
std::string bytes_of(std::initializer_list<T> values) {
  std::string bytes;
  for (const T value : values) bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  return bytes;
}

std::span<const std::byte> as_bytes(const std::string& text) { return std::as_bytes(std::span(text)); }

std::string replaced(std::string text, std::string_view what, std::string_view by) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return at == std::string::npos ? text : text.replace(at, what.size(), by);
}

// The vertices of two triangles, of which the second is above the first, and the indices of both, each named twice.
const std::string kSix = bytes_of<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 2, 1, 0, 2, 0, 1, 2});
const std::string kFirstSecond = bytes_of<std::uint16_t>({0, 1, 2, 3, 4, 5});

// A document of one mesh, one node and one buffer, of kSix and kFirstSecond.
constexpr char kPlain[] = R"({
  "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
  "nodes": [{"mesh": 0}],
  "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
  "accessors": [{"bufferView": 0, "componentType": 5126, "count": 6, "type": "VEC3"},
                {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}],
  "bufferViews": [{"buffer": 0, "byteLength": 72}, {"buffer": 0, "byteOffset": 72, "byteLength": 12}],
  "buffers": [{"byteLength": 84, "uri": "a.bin"}]})";

// The same document with the buffer in a .glb.
std::string glb(const std::string& json, const std::string& binary) {
  const auto word = [](std::size_t x) { return bytes_of<std::uint32_t>({static_cast<std::uint32_t>(x)}); };
  const std::string chunks = word(json.size()) + "JSON" + json + word(binary.size()) + std::string("BIN\0", 4) + binary;
  return "glTF" + word(2) + word(12 + chunks.size()) + chunks;
}

class GltfTest : public FileTest {
 protected:
  Result<SceneData> parsed(const std::string& text) const { return parse_gltf(as_bytes(text), (folder() / "a.gltf").string()); }
  SceneData scene(const std::string& text) const {
    Result<SceneData> result = parsed(text);
    EXPECT_TRUE(result) << result.message();
    return result ? *std::move(result) : SceneData{};
  }
  // With the buffer a.bin.
  SceneData scene(const std::string& text, const std::string& buffer) const {
    file("a.bin", buffer);
    return scene(text);
  }
  static void expect_triangles(const TriangleMesh& mesh, const std::vector<Triangle>& expected) {
    ASSERT_EQ(mesh.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
      const Triangle t = mesh.triangle(i);
      EXPECT_TRUE(t.v0 == expected[i].v0 && t.v1 == expected[i].v1 && t.v2 == expected[i].v2) << i;
    }
  }
  static inline const std::vector<Triangle> kBoth = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 0, 2}, {1, 0, 2}, {0, 1, 2}}};
};

TEST_F(GltfTest, BuffersInFilesInTheTextAndInTheBinaryChunk) {
  expect_triangles(scene(kPlain, kSix + kFirstSecond).mesh, kBoth);
  file("a b.bin", kSix + kFirstSecond);
  expect_triangles(scene(replaced(kPlain, "a.bin", "./a%20b.bin")).mesh, kBoth);
  const std::string without_uri = replaced(kPlain, R"(, "uri": "a.bin")", "");
  expect_triangles(scene(glb(without_uri, kSix + kFirstSecond + "pad")).mesh, kBoth);
  expect_triangles(load_scene(file("b.GLB", glb(without_uri, kSix + kFirstSecond)))->mesh, kBoth);

  std::string base64;
  const std::string all = kSix + kFirstSecond;
  for (std::size_t i = 0; i < all.size(); i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k) bits = bits << 8 | static_cast<std::uint8_t>(all[i + k]);
    for (int k = 18; k >= 0; k -= 6)
      base64 += "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/"[bits >> k & 63u];
  }
  expect_triangles(scene(replaced(kPlain, "a.bin", "data:application/octet-stream;base64," + base64)).mesh, kBoth);
}

TEST_F(GltfTest, IndicesOfAllTypesOrNone) {
  const std::string none = replaced(kPlain, R"(, "indices": 1)", "");
  expect_triangles(scene(none, kSix + kFirstSecond).mesh, kBoth);
  expect_triangles(
      scene(replaced(kPlain, "5123", "5121"), kSix + bytes_of<std::uint8_t>({3, 4, 5, 0, 1, 2, 9, 9, 9, 9, 9, 9})).mesh,
      {kBoth[1], kBoth[0]});
  const std::string words = replaced(replaced(replaced(kPlain, "5123", "5125"), "\"byteLength\": 12", "\"byteLength\": 24"),
                                     "\"byteLength\": 84", "\"byteLength\": 96");
  expect_triangles(scene(words, kSix + bytes_of<std::uint32_t>({0, 1, 2, 3, 4, 5})).mesh, kBoth);
}

TEST_F(GltfTest, StripsAndFansAndWhatHasNoTriangles) {
  const auto with_mode = [&](const std::string& mode) {
    return scene(replaced(kPlain, R"("indices": 1)", R"("mode": )" + mode), kSix + kFirstSecond).mesh;
  };
  const auto v = [&](int i) { return i < 3 ? (&kBoth[0].v0)[i] : (&kBoth[1].v0)[i - 3]; };
  const auto t = [&](int a, int b, int c) { return Triangle{v(a), v(b), v(c)}; };
  expect_triangles(with_mode("5"), {t(0, 1, 2), t(1, 3, 2), t(2, 3, 4), t(3, 5, 4)});
  expect_triangles(with_mode("6"), {t(1, 2, 0), t(2, 3, 0), t(3, 4, 0), t(4, 5, 0)});
  for (const char* mode : {"0", "1", "2", "3"}) EXPECT_EQ(with_mode(mode).size(), 0u) << mode;
  EXPECT_EQ(scene(replaced(kPlain, "POSITION", "NORMAL"), kSix + kFirstSecond).mesh.size(), 0u);
}

TEST_F(GltfTest, PrimitivesShareVertices) {
  const std::string twice =
      replaced(kPlain, R"("indices": 1})", R"("indices": 1}, {"attributes": {"POSITION": 0}, "mode": 4})");
  const SceneData both = scene(twice, kSix + kFirstSecond);
  EXPECT_EQ(both.mesh.vertices.size(), 6u);
  expect_triangles(both.mesh, {kBoth[0], kBoth[1], kBoth[0], kBoth[1]});
}

TEST_F(GltfTest, ElementsMayLieInterleaved) {
  std::string interleaved;
  for (std::size_t i = 0; i < 6; ++i) interleaved += "pad!" + kSix.substr(12 * i, 12);
  const std::string text = replaced(replaced(replaced(kPlain, R"("bufferView": 0,)", R"("bufferView": 0, "byteOffset": 4,)"),
                                             R"("byteLength": 72})", R"("byteLength": 96, "byteStride": 16})"),
                                    R"("byteOffset": 72)", R"("byteOffset": 96)");
  expect_triangles(scene(replaced(text, R"("byteLength": 84)", R"("byteLength": 108)"), interleaved + kFirstSecond).mesh,
                   kBoth);
}

TEST_F(GltfTest, IntegersAreConverted) {
  const std::string start = replaced(kPlain, R"(, "indices": 1)", "");
  const auto first_vertices = [&](const std::string& type, const std::string& bytes) {
    return scene(replaced(replaced(start, "5126, \"count\": 6", type + ", \"count\": 3"), R"("scene": 0)",
                          R"("extensionsRequired": ["KHR_mesh_quantization"])"),
                 bytes + std::string(84, '\0'))
        .mesh.triangle(0);
  };
  const Triangle shorts = first_vertices("5122", bytes_of<std::int16_t>({-5, 6, 7, 0, 0, 0, 32767, 0, 0}));
  EXPECT_EQ(shorts.v0, (Vec3{-5, 6, 7}));
  EXPECT_EQ(shorts.v2, (Vec3{32767, 0, 0}));
  const Triangle fractions =
      first_vertices("5120, \"normalized\": true", bytes_of<std::int8_t>({-128, -127, 127, 0, 1, 64, 0, 0, 0}));
  EXPECT_EQ(fractions.v0, (Vec3{-1, -1, 1}));
  EXPECT_EQ(fractions.v1, (Vec3{0, 1 / 127.0f, 64 / 127.0f}));
  const Triangle unsigneds =
      first_vertices("5123, \"normalized\": true", bytes_of<std::uint16_t>({65535, 0, 1, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(unsigneds.v0, (Vec3{1, 0, 1 / 65535.0f}));
}

TEST_F(GltfTest, SparseAccessors) {
  // The second vertex is replaced, with another view for the place and the value.
  const std::string sparse = R"("sparse": {"count": 1, "indices": {"bufferView": 1, "byteOffset": 2, "componentType": 5123},
                                           "values": {"bufferView": 0, "byteOffset": 48}}, )";
  const std::string start = replaced(kPlain, R"(, "indices": 1)", "");
  expect_triangles(scene(replaced(start, R"("bufferView": 0, )", R"("bufferView": 0, )" + sparse), kSix + kFirstSecond).mesh,
                   {{{0, 0, 0}, {1, 0, 2}, {0, 1, 0}}, kBoth[1]});
  const Vec3 zero{0, 0, 0};
  expect_triangles(scene(replaced(start, R"("bufferView": 0, )", sparse), kSix + kFirstSecond).mesh,
                   {{zero, {1, 0, 2}, zero}, {zero, zero, zero}});
}

TEST_F(GltfTest, NodesPlaceMeshesDepthFirst) {
  // Turned by a quarter about z, then moved, then scaled by the parent; and a matrix by columns.
  const std::string nodes = R"("nodes": [{"children": [1, 3], "scale": [2, 2, 2]},
    {"mesh": 0, "rotation": [0, 0, 3, 3], "translation": [10, 0, 0], "children": [2]},
    {"mesh": 0, "translation": [0, 0, 1]},
    {"mesh": 0, "matrix": [0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 7, 1]}])";
  const SceneData placed = scene(
      replaced(replaced(kPlain, R"("nodes": [{"mesh": 0}])", nodes), R"("indices": 1)", R"("mode": 4)"), kSix + kFirstSecond);
  ASSERT_EQ(placed.mesh.size(), 6u);
  EXPECT_FALSE(placed.instances);
  const auto near = [](Vec3 a, Vec3 b) { return length(Vec3d(a) - Vec3d(b)) < 1e-5; };
  EXPECT_TRUE(near(placed.mesh.triangle(0).v1, {20, 2, 0}));
  EXPECT_TRUE(near(placed.mesh.triangle(0).v2, {18, 0, 0}));
  EXPECT_TRUE(near(placed.mesh.triangle(2).v1, {20, 2, 2}));
  EXPECT_TRUE(near(placed.mesh.triangle(4).v1, {0, 0, 16}));
  EXPECT_TRUE(near(placed.mesh.triangle(5).v0, {4, 0, 14}));
}

TEST_F(GltfTest, TheSceneThatIsNamedOrAllNodes) {
  const std::string two = replaced(replaced(kPlain, R"("nodes": [{"mesh": 0}])",
                                            R"("nodes": [{"mesh": 0}, {"children": [2]}, {"mesh": 0, "scale": [3, 3, 3]}])"),
                                   R"("scenes": [{"nodes": [0]}])", R"("scenes": [{"nodes": [0]}, {"nodes": [1]}, {}])");
  EXPECT_EQ(scene(two, kSix + kFirstSecond).mesh.triangle(0).v1, (Vec3{1, 0, 0}));
  EXPECT_EQ(scene(replaced(two, R"("scene": 0)", R"("scene": 1)")).mesh.triangle(0).v1, (Vec3{3, 0, 0}));
  EXPECT_EQ(scene(replaced(two, R"("scene": 0, )", "")).mesh.size(), 2u);
  EXPECT_EQ(scene(replaced(two, R"("scene": 0)", R"("scene": 2)")).mesh.size(), 0u);
  const std::string no_scenes =
      replaced(replaced(two, R"("scene": 0, )", ""), R"("scenes": [{"nodes": [0]}, {"nodes": [1]}, {}],)", "");
  EXPECT_EQ(scene(no_scenes).mesh.size(), 4u);
}

TEST_F(GltfTest, CamerasAndLights) {
  const std::string nodes = R"("nodes": [{"mesh": 0}, {"camera": 1, "translation": [1, 2, 3], "rotation": [0, 1, 0, 0]},
    {"camera": 0}, {"extensions": {"KHR_lights_punctual": {"light": 0}}},
    {"extensions": {"KHR_lights_punctual": {"light": 1}}, "translation": [4, 5, 6]}, {"name": "door", "camera": 1}],
    "cameras": [{"type": "orthographic", "orthographic": {}}, {"type": "perspective", "perspective": {"yfov": 1.5, "znear": 1}}],
    "extensions": {"KHR_lights_punctual": {"lights": [{"type": "directional"}, {"type": "spot"}]}})";
  const std::string text =
      replaced(replaced(kPlain, R"("nodes": [{"mesh": 0}])", nodes), R"("nodes": [0])", R"("nodes": [0, 1, 2, 3, 4, 5])");
  const SceneData seen = scene(text, kSix + kFirstSecond);
  ASSERT_EQ(seen.cameras.size(), 2u);
  EXPECT_EQ(seen.cameras[0].eye, (Vec3{1, 2, 3}));
  EXPECT_EQ(seen.cameras[0].name, "camera 1");
  EXPECT_NEAR(seen.cameras[0].at.z - 3, std::sqrt(14.0), 1e-5) << "turned about y, it looks along +z";
  EXPECT_NEAR(seen.cameras[0].vfov_degrees, 1.5 * 180 / std::numbers::pi, 1e-4);
  EXPECT_EQ(seen.cameras[1].name, "door");
  ASSERT_TRUE(seen.light);
  EXPECT_EQ(seen.light->center, (Vec3{4, 5, 6}));

  // What stands beside the file comes first.
  file("a.json", R"({"cameras": [{"eye": [9, 9, 9], "at": [0, 0, 0]}], "light": {"point": [7, 7, 7]}})");
  const auto loaded = load_scene(file("a.gltf", text));
  ASSERT_TRUE(loaded) << loaded.message();
  ASSERT_EQ(loaded->cameras.size(), 3u);
  EXPECT_EQ(loaded->cameras[0].eye, (Vec3{9, 9, 9}));
  EXPECT_EQ(loaded->light->center, (Vec3{7, 7, 7}));
}

// Kept as instances or made one mesh: the same triangles under the same numbers.
TEST_F(GltfTest, ManyCopiesOfALargeMeshAreInstances) {
  const auto copies = [&](std::size_t count, const char* first) {
    std::string nodes = std::string("\"nodes\": [") + first, list = "\"nodes\": [0";
    for (std::size_t i = 1; i < count; ++i) {
      nodes += R"(, {"mesh": 0, "translation": [)" + std::to_string(i) + ", 0, 0]}";
      list += ", " + std::to_string(i);
    }
    return replaced(replaced(kPlain, R"("nodes": [{"mesh": 0}])", nodes + "]"), R"("nodes": [0)", list);
  };
  std::string corners;
  constexpr std::uint16_t kTriangles = 20000;
  for (int i = 0; i < kTriangles; ++i) corners += bytes_of<std::uint16_t>({0, 1, 2});
  const auto large = [&](const std::string& text) {
    return replaced(replaced(replaced(text, R"(5123, "count": 6)", R"(5123, "count": 60000)"), R"("byteLength": 12)",
                             R"("byteLength": 120000)"),
                    R"("byteLength": 84)", R"("byteLength": 120072)");
  };
  file("a.bin", kSix + corners);
  const SceneData many = scene(large(copies(421, R"({"mesh": 0})")));
  ASSERT_TRUE(many.instances);
  EXPECT_EQ(many.triangles().size(), 421u * kTriangles);
  EXPECT_EQ(many.triangles().triangle(31 * kTriangles + 7).v1, (Vec3{32, 0, 0}));
  EXPECT_FALSE(scene(large(copies(50, R"({"mesh": 0})"))).instances) << "fewer triangles than a large mesh";
  const SceneData hidden = scene(large(copies(421, R"({"mesh": 0, "scale": [0, 0, 0]})")));
  ASSERT_TRUE(hidden.instances);
  EXPECT_EQ(hidden.triangles().size(), 420u * kTriangles);
  const Result<SceneData> singular = parsed(large(copies(421, R"({"mesh": 0, "scale": [1, 1, 0]})")));
  ASSERT_FALSE(singular);
  EXPECT_NE(singular.message().find("instance 1: its transform is singular"), std::string::npos) << singular.message();
}

TEST_F(GltfTest, InstancesByAccessors) {
  const std::string text = replaced(
      kPlain, R"({"mesh": 0})",
      R"({"mesh": 0, "translation": [0, 0, 1], "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 0}}}})");
  const SceneData six = scene(text, kSix + kFirstSecond);
  ASSERT_EQ(six.mesh.size(), 12u);
  EXPECT_EQ(six.mesh.triangle(3).v0, (Vec3{1, 0, 3}));

  // Turned by normalised bytes, half a turn about z; and scaled by the vertices.
  const std::string turned =
      replaced(replaced(replaced(text, R"("TRANSLATION": 0)", R"("ROTATION": 2, "SCALE": 0)"), R"("type": "SCALAR"})",
                        R"("type": "SCALAR"}, {"componentType": 5120, "normalized": true, "count": 6, "type": "VEC4", "sparse":
                  {"count": 6, "indices": {"bufferView": 1, "componentType": 5123}, "values": {"bufferView": 2}}})"),
               R"({"buffer": 0, "byteOffset": 72, "byteLength": 12})",
               R"({"buffer": 0, "byteOffset": 72, "byteLength": 12}, {"buffer": 0, "byteOffset": 84, "byteLength": 24})");
  std::string turns;
  for (int i = 0; i < 6; ++i) turns += bytes_of<std::int8_t>({0, 0, 127, 0});
  const SceneData scaled = scene(replaced(turned, R"("byteLength": 84)", R"("byteLength": 108)"), kSix + kFirstSecond + turns);
  ASSERT_EQ(scaled.mesh.size(), 12u);
  EXPECT_EQ(scaled.mesh.triangle(8).v1, (Vec3{-1, 0, 1}));
  EXPECT_EQ(scaled.mesh.triangle(9).v2, (Vec3{0, 0, 5}));
  file("a.bin", kSix + kFirstSecond);
  const Result<SceneData> uneven =
      parsed(replaced(replaced(text, R"("TRANSLATION": 0)", R"("TRANSLATION": 0, "SCALE": 2)"), R"("type": "SCALAR"})",
                      R"("type": "SCALAR"}, {"bufferView": 0, "componentType": 5126, "count": 5, "type": "VEC3"})"));
  ASSERT_FALSE(uneven);
  EXPECT_NE(uneven.message().find("attributes: must have as many elements each"), std::string::npos) << uneven.message();
}

TEST_F(GltfTest, MistakesAreNamed) {
  const std::string good = kPlain;
  const struct {
    const char* what;
    const char* by;
    const char* message;
  } mistakes[] = {
      {R"("asset": {"version": "2.0"}, )", "", "asset is missing"},
      {R"("version": "2.0")", R"("version": "1.0")", "asset.version: is '1.0'; only glTF 2.0 can be read"},
      {R"("scene": 0)", R"("extensionsRequired": ["KHR_draco_mesh_compression"])",
       "requires the extension 'KHR_draco_mesh_compression'"},
      {R"("version": "2.0")", R"("version": "2.0", "minVersion": "2.1")", "asset.minVersion: is '2.1'; only glTF 2.0"},
      {R"("scene": 0)", R"("scene": 1)", "scene: is 1, but there are 1"},
      {R"("nodes": [0])", R"("nodes": [0, 0])", "nodes[0]: is reached twice"},
      {R"({"mesh": 0})", R"({"mesh": 0, "children": [0]})", "nodes[0]: is reached twice"},
      {R"({"mesh": 0})", R"({"mesh": 0, "children": [1]})", "nodes[0].children[0]: is 1, but there are 1"},
      {R"({"mesh": 0})", R"({"mesh": 0.5})", "nodes[0].mesh: must be a number without a fraction"},
      {R"({"mesh": 0})", R"({"mesh": -1})", "nodes[0].mesh: must be a number without a fraction, and not negative"},
      {R"({"mesh": 0})", R"({"mesh": 1})", "nodes[0].mesh: is 1, but there are 1"},
      {R"({"mesh": 0})", R"({"mesh": 0, "rotation": [0, 0, 0, 0]})", "nodes[0].rotation: must not be zero"},
      {R"({"mesh": 0})", R"({"mesh": 0, "scale": [1, 2]})", "nodes[0].scale: must be 3 numbers"},
      {R"({"mesh": 0})", R"({"matrix": [1,0,0,1, 0,1,0,0, 0,0,1,0, 0,0,0,1]})", "nodes[0].matrix: is not affine"},
      {R"({"mesh": 0})", R"({"camera": 0})", "cameras is missing"},
      {R"("indices": 1)", R"("indices": 0)", "accessors[0].type: must be SCALAR here"},
      {R"("POSITION": 0)", R"("POSITION": 1)", "accessors[1].type: must be VEC3 here"},
      {R"("componentType": 5126)", R"("componentType": 5124)", "accessors[0].componentType: 5124 is no type of numbers"},
      {R"("componentType": 5123)", R"("componentType": 5122)", "accessors[1].componentType: must be an unsigned integer"},
      {R"("count": 6, "type": "VEC3")", R"("count": 7, "type": "VEC3")", "accessors[0]: goes beyond the end of its view"},
      {R"("count": 6, "type": "VEC3")", R"("count": 0, "type": "VEC3")", "accessors[0].count: must not be 0"},
      {R"("count": 6, "type": "VEC3")", R"("count": 9007199254740992, "type": "VEC3")", "accessors[0]: goes beyond"},
      {R"("count": 6, "type": "VEC3")", R"("count": 5, "type": "VEC3")", "meshes[0].primitives[0]: names vertex 5 of 5"},
      {R"("count": 6, "type": "SCALAR")", R"("count": 5, "type": "SCALAR")", "has 5 corners, which is no multiple of three"},
      {R"("bufferView": 0, "componentType": 5126, "count": 6)", R"("componentType": 5126, "count": 65537)",
       "accessors[0]: names the same numbers, or zeros, so often that"},
      {R"("byteLength": 72})", R"("byteLength": 72, "byteStride": 8})", "its elements overlap"},
      {R"("byteOffset": 72)", R"("byteOffset": 90)", "bufferViews[1]: goes beyond the end of its buffer"},
      {R"("byteLength": 84)", R"("byteLength": 85)", "buffers[0]: is stated to have 85 bytes, but there are 84"},
      {R"("uri": "a.bin")", R"("uri": "b.bin")", "b.bin: cannot open"},
      {R"("uri": "a.bin")", R"("uri": "http://host/a.bin")", "others are not followed"},
      {R"("uri": "a.bin")", R"("uri": "/etc/passwd")", "others are not followed"},
      {R"("uri": "a.bin")", R"("uri": "data:;base64,AA*A")", "a character that is no digit of base64"},
      {R"(, "uri": "a.bin")", "", "buffers[0]: has no uri"},
      {R"("buffers": [)", R"("buffers": [1)", "is not valid JSON"},
  };
  file("a.bin", kSix + kFirstSecond);
  for (const auto& [what, by, message] : mistakes) {
    const Result<SceneData> result = parsed(replaced(good, what, by));
    ASSERT_FALSE(result) << message;
    EXPECT_NE(result.message().find(message), std::string::npos) << result.message();
    EXPECT_NE(result.message().find("a.gltf"), std::string::npos) << result.message();
  }
}

// Found by a review: small files that made gigabytes.
TEST_F(GltfTest, NumbersThatAreNamedAgainAndAgain) {
  std::string primitive = R"({"attributes": {"POSITION": 0}, "indices": 1})", primitives = primitive;
  for (int i = 0; i < 4000; ++i) primitives += ", " + primitive;
  file("a.bin", kSix + kFirstSecond);
  EXPECT_EQ(scene(replaced(kPlain, primitive, primitives)).mesh.size(), 8002u) << "two triangles in some 40 bytes";
  // A strip of a thousand triangles for each such entry.
  std::string corners;
  for (int i = 0; i < 1000; ++i) corners += static_cast<char>(i % 6);
  file("a.bin", kSix + corners);
  const std::string strips = replaced(
      replaced(replaced(kPlain, "5123, \"count\": 6", "5121, \"count\": 1000"), "\"byteLength\": 12", "\"byteLength\": 1000"),
      "\"byteLength\": 84", "\"byteLength\": 1072");
  primitive = R"({"attributes": {"POSITION": 0}, "mode": 5, "indices": 1})", primitives = primitive;
  for (int i = 0; i < 4000; ++i) primitives += ", " + primitive;
  const Result<SceneData> many = parsed(replaced(strips, R"({"attributes": {"POSITION": 0}, "indices": 1})", primitives));
  ASSERT_FALSE(many);
  EXPECT_NE(many.message().find("names the same numbers, or zeros, so often that"), std::string::npos) << many.message();
}

TEST_F(GltfTest, TheOneInstanceThereIsNeedNotBeOfTheFirstMesh) {
  const std::string two = replaced(replaced(kPlain, R"("meshes": [)", R"("meshes": [{"primitives": []}, )"), R"({"mesh": 0})",
                                   R"({"mesh": 0, "scale": [0, 0, 0]}, {"mesh": 1})");
  expect_triangles(scene(replaced(two, R"("nodes": [0])", R"("nodes": [0, 1])"), kSix + kFirstSecond).mesh, kBoth);
}

TEST_F(GltfTest, CamerasAndLightsThatCannotBeUsed) {
  file("a.bin", kSix + kFirstSecond);
  const std::string cameras = R"("cameras": [{"perspective": {"yfov": 1}}, {"perspective": {"yfov": 4}}], "extensions":
      {"KHR_lights_punctual": {"lights": [{"type": "point"}]}}, "nodes": [{"mesh": 0}])";
  const auto with = [&](const std::string& node) {
    return replaced(replaced(kPlain, R"("nodes": [{"mesh": 0}])", cameras), R"({"mesh": 0})", node);
  };
  EXPECT_EQ(scene(with(R"({"camera": 0, "scale": [0, 0, 0]})")).cameras.size(), 0u);
  EXPECT_EQ(parsed(with(R"({"camera": 1})")).message(),
            (folder() / "a.gltf").string() + ": cameras[1].perspective.yfov: must lie between 0 and pi");
  EXPECT_NE(parsed(with(R"({"camera": 0, "scale": [1, 0, 1]})")).message().find("nodes[0]: its camera cannot be used"),
            std::string::npos);
  EXPECT_NE(parsed(with(R"({"translation": [1e39, 0, 0], "extensions": {"KHR_lights_punctual": {"light": 0}}})"))
                .message()
                .find("nodes[0]: its light is too far away"),
            std::string::npos);
}

TEST_F(GltfTest, DeepTreesOfNodes) {
  constexpr int kDepth = 100000;
  std::string nodes = "\"nodes\": [";
  for (int i = 1; i < kDepth; ++i) nodes += "{\"children\": [" + std::to_string(i) + "]}, ";
  EXPECT_EQ(scene(replaced(kPlain, R"("nodes": [{"mesh": 0})", nodes + R"({"mesh": 0})"), kSix + kFirstSecond).mesh.size(), 2u);
}

TEST_F(GltfTest, CutOffContainers) {
  const std::string whole = glb(replaced(kPlain, R"(, "uri": "a.bin")", ""), kSix + kFirstSecond);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const Result<SceneData> result = parsed(whole.substr(0, size));
    ASSERT_FALSE(result) << size;
    EXPECT_FALSE(result.message().empty());
  }
  std::string old = whole;
  old[4] = 1;
  EXPECT_NE(parsed(old).message().find("is of version 1 of glTF"), std::string::npos);
}

TEST_F(GltfTest, CanBeInterrupted) {
  file("a.bin", kSix + kFirstSecond);
  const LoadOptions stop{[](std::string_view, double) { return false; }};
  EXPECT_EQ(parse_gltf(as_bytes(kPlain), (folder() / "a.gltf").string(), stop).message(), kInterrupted);
}

}  // namespace
}  // namespace accel
