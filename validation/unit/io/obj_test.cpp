#include "libaccel/io/obj.h"

#include <cmath>

#include "validation/unit/io/io_test_support.h"

namespace accel {
namespace {

Result<TriangleMesh> parse(std::string_view text) { return parse_obj(std::as_bytes(std::span(text)), "a.obj"); }

TriangleMesh parsed(std::string_view text) {
  Result<TriangleMesh> mesh = parse(text);
  EXPECT_TRUE(mesh) << mesh.message();
  return mesh ? *mesh : TriangleMesh{};
}

void expect_error(std::string_view text, std::string_view part) {
  const Result<TriangleMesh> mesh = parse(text);
  ASSERT_FALSE(mesh) << text;
  EXPECT_NE(mesh.message().find(part), std::string::npos) << mesh.message();
}

void expect_triangle(const TriangleMesh& mesh, std::size_t i, std::uint32_t v0, std::uint32_t v1, std::uint32_t v2) {
  ASSERT_LT(i, mesh.size());
  EXPECT_EQ(mesh.triangles[i].v0, v0) << i;
  EXPECT_EQ(mesh.triangles[i].v1, v1) << i;
  EXPECT_EQ(mesh.triangles[i].v2, v2) << i;
}

constexpr char kSquareVertices[] = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

TEST(Obj, EverySpellingOfCorners) {
  const TriangleMesh mesh =
      parsed(std::string(kSquareVertices) +
             "vn 0 0 1\nvt 0 0\nf 1 2 3\nf 1/1 2/1 3/1\nf 1//1 2//1 4//1\nf 1/1/1 3/1/1 4/1/1\nf -4 -3 -1\n");
  ASSERT_EQ(mesh.size(), 5u);
  expect_triangle(mesh, 0, 0, 1, 2);
  expect_triangle(mesh, 1, 0, 1, 2);
  expect_triangle(mesh, 2, 0, 1, 3);
  expect_triangle(mesh, 3, 0, 2, 3);
  expect_triangle(mesh, 4, 0, 1, 3);
}

TEST(Obj, PolygonsTakeConsecutiveNumbers) {
  const TriangleMesh mesh = parsed(std::string(kSquareVertices) + "f 1 2 3\nf 1 2\nf 1 2 3 4\nf 4 3 2\n");
  ASSERT_EQ(mesh.size(), 4u);
  expect_triangle(mesh, 1, 0, 1, 2);
  expect_triangle(mesh, 2, 0, 2, 3);
  expect_triangle(mesh, 3, 3, 2, 1);
}

// The shorter diagonal of this quad lies outside it: tinyobjloader's own triangulation covers the notch.
TEST(Obj, ConcaveQuad) {
  const TriangleMesh mesh = parsed("v 1 -8 0\nv 0 0 0\nv -1 -8 0\nv 0 -2 0\nf 1 2 3 4\n");
  ASSERT_EQ(mesh.size(), 2u);
  for (const IndexTriple& t : mesh.triangles) EXPECT_TRUE(t.v0 == 3 || t.v1 == 3 || t.v2 == 3);
  for (const IndexTriple& t : mesh.triangles) EXPECT_TRUE(t.v0 == 1 || t.v1 == 1 || t.v2 == 1);
}

TEST(Obj, BlanksLineEndsAndComments) {
  const std::string_view lines[] = {"v\t0 0\t0", "v 1 0 0   # a comment", "  v 0 1 0",       "",      "# f 9 9 9",
                                    "g",         "usemtl none",           "mtllib none.mtl", "s off", "f 1 2 3 # another"};
  for (const std::string_view end : {"\n", "\r\n", "\r"}) {
    std::string text;
    for (const std::string_view line : lines) (text += line) += end;
    const TriangleMesh mesh = parsed(text);
    EXPECT_EQ(mesh.vertices.size(), 3u);
    ASSERT_EQ(mesh.size(), 1u);
    expect_triangle(mesh, 0, 0, 1, 2);
  }
  EXPECT_EQ(parsed(std::string(kSquareVertices) + "f 1 2 3").size(), 1u);  // no line end at all
}

TEST(Obj, LinesAreContinued) {
  for (const std::string end : {"\n", "\r\n", "\r"}) {
    const std::string text = "v 0 0 \\" + end + "0" + end + "v\\" + end + "1 0 0" + end + "# a path\\" + end + "v 0 1 0 # \\" +
                             end + "f 1 \\" + end + "\\" + end + "2 3" + end;
    const TriangleMesh mesh = parsed(text);
    ASSERT_EQ(mesh.vertices.size(), 3u);
    EXPECT_EQ(mesh.vertices[1], (Vec3{1, 0, 0}));
    ASSERT_EQ(mesh.size(), 1u);
    expect_triangle(mesh, 0, 0, 1, 2);
    expect_error(text + "f 1 2 4" + end, "a.obj:10: a face names vertex 4");
    expect_error(text + "f 1 2 x\\" + end, "a.obj:11: 'x' is not a face's corner");
    expect_error(text + "f 1 2 x" + end, "a.obj:10: 'x' is not a face's corner");
  }
  EXPECT_EQ(parsed("v 0 0 0\no an object called \\\nv\n").vertices.size(), 1u);
  expect_error("v 0 0 \\ \n0\n", "a.obj:1: '\\' is not a number");
}

TEST(Obj, AByteOrderMarkIsPassedOver) {
  const TriangleMesh mesh = parsed(std::string("\xef\xbb\xbf") + kSquareVertices + "f 1 2 3\n");
  EXPECT_EQ(mesh.vertices.size(), 4u);
  EXPECT_EQ(mesh.size(), 1u);
}

TEST(Obj, FacesWithoutTrianglesAreCounted) {
  std::uint64_t skipped = 0;
  const std::string text = std::string(kSquareVertices) + "f 1 2 3\nf 1 2\nf 1 # 2 3\n";
  ASSERT_TRUE(parse_obj(std::as_bytes(std::span(text)), "a.obj", {.skipped_faces = &skipped}));
  EXPECT_EQ(skipped, 2u);
}

TEST(Obj, WeightsAndColoursArePassedOver) {
  const TriangleMesh mesh = parsed("v 1 2 3 0.5\nv 4 5 6 0.1 0.2 0.3\nv 7 8 9\n");
  ASSERT_EQ(mesh.vertices.size(), 3u);
  EXPECT_EQ(mesh.vertices[0], (Vec3{1, 2, 3}));
  EXPECT_EQ(mesh.vertices[1], (Vec3{4, 5, 6}));
}

TEST(Obj, FacesMayNameVerticesThatFollow) {
  const TriangleMesh mesh = parsed("f 1 2 3 4\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n");
  EXPECT_EQ(mesh.size(), 2u);
  expect_error("f 1 2 3\n\nf 1 2 4\nv 0 0 0\nv 1 0 0\nv 1 1 0\n", "a.obj:3: a face names vertex 4, but the file has 3");
}

TEST(Obj, NumbersThatAreNotFiniteAreKept) {
  const TriangleMesh mesh = parsed("v nan -inf 1e999\nv 1e-999 -0 +2.5\n");
  EXPECT_TRUE(std::isnan(mesh.vertices[0].x));
  EXPECT_EQ(mesh.vertices[0].y, -HUGE_VALF);
  EXPECT_EQ(mesh.vertices[0].z, HUGE_VALF);
  EXPECT_EQ(mesh.vertices[1], (Vec3{0, 0, 2.5f}));
}

TEST(Obj, DecimalsOfFloatsAreExact) {
  const float values[] = {0.1f, 1.0f / 3, 16777215.0f, 3.4028235e38f, 1.17549435e-38f, -123.456787f};
  for (const float value : values) {
    char line[100];
    std::snprintf(line, sizeof(line), "v %.9g 0 0\n", static_cast<double>(value));
    EXPECT_EQ(parsed(line).vertices[0].x, value) << line;
  }
}

TEST(Obj, ErrorsNameTheLine) {
  const std::string square = kSquareVertices;
  expect_error("", "neither vertices nor faces");
  expect_error("PK\x03\x04 this is a zip file", "neither vertices nor faces");
  expect_error("v 0 0 0\nv 1 two 0\n", "a.obj:2: 'two' is not a number");
  expect_error("v 0 0 0\r\nv 1 0\r\n", "a.obj:2: a vertex needs three numbers");
  expect_error("v 0 0 0\no v\n v\nv 1 0 0\n", "a.obj:3: a vertex needs three numbers");
  expect_error("v 0 0 0\nv", "a.obj:2: a vertex needs three numbers");
  expect_error("v 1,5 0 0\n", "a.obj:1: '1,5' is not a number");
  expect_error("v 1.2.3 0 0\n", "a.obj:1: '1.2.3' is not a number");
  expect_error("v 5-2 0 0\n", "a.obj:1: '5-2' is not a number");
  expect_error("v 1e 0 0\n", "a.obj:1: '1e' is not a number");
  expect_error("v +-1 0 0\n", "a.obj:1: '+-1' is not a number");
  expect_error("v 1e999x 0 0\n", "a.obj:1: '1e999x' is not a number");
  expect_error(square + "f 1-2 2 3\n", "a.obj:5: '1-2' is not a face's corner");
  expect_error(square + "f 1 2 3/1-2\n", "a.obj:5: '3/1-2' is not a face's corner");
  expect_error(square + "f 1 2 3/1/1/1\n", "a.obj:5: '3/1/1/1' is not a face's corner");
  expect_error(square + "f 1 2 /3\n", "a.obj:5: '/3' is not a face's corner");
  expect_error(square + "f 1 2 -\n", "a.obj:5: '-' is not a face's corner");
  expect_error(square + "f 1 2 5\n", "a.obj:5: a face names vertex 5");
  expect_error(square + "f 1 2 0\n", "a.obj:5: a face names vertex 0");
  expect_error(square + "f 1 2 -5\nf 1 2 3\n", "a.obj:5: a face names vertex -5 of 4");
  expect_error(square + "f one 2 3\n", "'one' is not a face's corner");
  expect_error(square + "f 1 2 3.5\n", "'3.5' is not a face's corner");
  expect_error(square + "f 1 2 4294967297\n", "'4294967297' is not a face's corner");
}

TEST(Obj, CanBeInterrupted) {
  std::string text = kSquareVertices;
  for (int i = 0; i < 10000; ++i) text += "f 1 2 3\n";
  const Result<TriangleMesh> mesh =
      parse_obj(std::as_bytes(std::span(text)), "a.obj", {[](std::string_view, double) { return false; }});
  ASSERT_FALSE(mesh);
  EXPECT_EQ(mesh.message(), kInterrupted);
}

}  // namespace
}  // namespace accel
