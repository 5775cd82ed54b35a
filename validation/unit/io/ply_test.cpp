#include "libaccel/io/ply.h"

#include <cmath>
#include <cstring>

#include "validation/unit/io/io_test_support.h"

namespace accel {
namespace {

Result<TriangleMesh> parse_text(std::string_view text) { return parse_ply(std::as_bytes(std::span(text)), "a.ply"); }

void expect_ply_error(std::string_view text, std::string_view part) {
  const Result<TriangleMesh> mesh = parse_text(text);
  ASSERT_FALSE(mesh) << part;
  EXPECT_NE(mesh.message().find(part), std::string::npos) << mesh.message();
  EXPECT_NE(mesh.message().find("a.ply"), std::string::npos) << mesh.message();
}

// Numbers as they stand in a binary file.
class Bytes {
 public:
  explicit Bytes(bool big_endian = false) : big_(big_endian) {}

  template <class T>
  Bytes& add(T value) {
    char number[sizeof(T)];
    std::memcpy(number, &value, sizeof(T));
    if (big_) std::reverse(number, number + sizeof(T));
    text_.append(number, sizeof(T));
    return *this;
  }
  template <class T>
  Bytes& add_type(const std::string& type, T value) {
    if (type == "char") return add(static_cast<std::int8_t>(value));
    if (type == "uchar") return add(static_cast<std::uint8_t>(value));
    if (type == "short") return add(static_cast<std::int16_t>(value));
    if (type == "ushort") return add(static_cast<std::uint16_t>(value));
    if (type == "int") return add(static_cast<std::int32_t>(value));
    if (type == "uint") return add(static_cast<std::uint32_t>(value));
    if (type == "float") return add(static_cast<float>(value));
    return add(static_cast<double>(value));
  }
  const std::string& text() const { return text_; }

 private:
  bool big_;
  std::string text_;
};

std::string header(const std::string& format, const std::string& vertex, const std::string& face, std::uint64_t vertices = 4,
                   std::uint64_t faces = 2) {
  return "ply\nformat " + format + " 1.0\ncomment made by hand\nelement vertex " + std::to_string(vertices) + "\n" + vertex +
         "element face " + std::to_string(faces) + "\n" + face + "end_header\n";
}

constexpr char kXyz[] = "property float x\nproperty float y\nproperty float z\n";
constexpr char kList[] = "property list uchar int vertex_indices\n";
constexpr int kSquareCorners[4][3] = {{0, 0, 5}, {1, 0, 5}, {1, 1, 5}, {0, 1, 5}};

Bytes square(bool big = false) {
  Bytes bytes(big);
  for (const auto& p : kSquareCorners) bytes.add(float(p[0])).add(float(p[1])).add(float(p[2]));
  return bytes;
}

// The square of kSquareCorners as the triangles 0 1 2 and 0 2 3.
void expect_square(const Result<TriangleMesh>& mesh) {
  ASSERT_TRUE(mesh) << mesh.message();
  ASSERT_EQ(mesh->vertices.size(), 4u);
  for (int i = 0; i < 4; ++i)
    EXPECT_EQ(mesh->vertices[i], (Vec3{float(kSquareCorners[i][0]), float(kSquareCorners[i][1]), float(kSquareCorners[i][2])}))
        << i;
  ASSERT_EQ(mesh->size(), 2u);
  for (std::uint32_t i = 0; i < 2; ++i) {
    EXPECT_EQ(mesh->triangles[i].v0, 0u);
    EXPECT_EQ(mesh->triangles[i].v1, i + 1);
    EXPECT_EQ(mesh->triangles[i].v2, i + 2);
  }
}

TEST(Ply, Ascii) {
  const std::string body = "0 0 5\n1 0 5\n1 1 5\n0 1 5\n";
  expect_square(parse_text(header("ascii", kXyz, kList) + body + "3 0 1 2\n3 0 2 3\n"));
  expect_square(parse_text(header("ascii", kXyz, kList, 4, 1) + body + "4 0 1 2 3"));
  expect_square(parse_text(header("ascii", kXyz, kList, 4, 3) + body + "2 0 1\r\n4 0 1 2 3\r\n0\r\n"));
}

// Every type of coordinate, of length and of index, in both byte orders, through the fast and the general paths.
TEST(Ply, BinaryOfEveryType) {
  const std::vector<std::string> numbers = {"char", "uchar", "short", "ushort", "int", "uint", "float", "double"};
  for (const bool big : {false, true}) {
    for (const std::string& coordinate : numbers) {
      for (const std::string& index : numbers) {
        const std::string& count = numbers[index.size() % 6];
        Bytes body(big);
        for (const auto& p : kSquareCorners)
          body.add_type(coordinate, p[0]).add_type(coordinate, p[1]).add_type(coordinate, p[2]);
        for (int i = 0; i < 2; ++i) body.add_type(count, 3).add_type(index, 0).add_type(index, i + 1).add_type(index, i + 2);
        const std::string c = "property " + coordinate;
        expect_square(
            parse_text(header(big ? "binary_big_endian" : "binary_little_endian", c + " x\n" + c + " y\n" + c + " z\n",
                              "property list " + count + " " + index + " vertex_index\n") +
                       body.text()));
      }
    }
  }
}

TEST(Ply, OtherPropertiesAndElementsArePassedOver) {
  const std::string text =
      "ply\r\nformat binary_little_endian 1.0\r\nobj_info x\r\nelement camera 2\r\nproperty list uchar double a\r\nproperty "
      "int b\r\n"
      "element vertex 4\r\nproperty uchar red\r\nproperty float z\r\nproperty double x\r\nproperty int id\r\nproperty short "
      "y\r\n"
      "element face 2\r\nproperty uchar flags\r\nproperty list uchar int vertex_indices\r\nproperty float quality\r\n"
      "element edge 3\r\nproperty int v\r\nend_header\r\n";
  Bytes body;
  body.add(std::uint8_t{2}).add(1.0).add(2.0).add(7).add(std::uint8_t{0}).add(8);
  for (const auto& p : kSquareCorners) body.add('r').add(float(p[2])).add(double(p[0])).add(-1).add(static_cast<short>(p[1]));
  for (int i = 0; i < 2; ++i) body.add('f').add(std::uint8_t{3}).add(0).add(i + 1).add(i + 2).add(0.5f);
  body.add(1).add(2).add(3);
  expect_square(parse_text(text + body.text()));
}

TEST(Ply, SecondListsInVerticesAndFaces) {
  Bytes body;
  for (const auto& p : kSquareCorners) body.add(std::uint8_t{1}).add(9).add(float(p[0])).add(float(p[1])).add(float(p[2]));
  for (int i = 0; i < 2; ++i) body.add(std::uint8_t{2}).add(1.f).add(2.f).add(std::uint8_t{3}).add(0).add(i + 1).add(i + 2);
  expect_square(parse_text(header("binary_little_endian", std::string("property list uchar int n\n") + kXyz,
                                  std::string("property list uchar float texcoord\n") + kList) +
                           body.text()));
}

TEST(Ply, FacesBeforeVertices) {
  const std::string text = std::string("ply\nformat ascii 1.0\nelement face 1\n") + kList + "element vertex 4\n" + kXyz +
                           "end_header\n4 0 1 2 3\n0 0 5\n1 0 5\n1 1 5\n0 1 5\n";
  expect_square(parse_text(text));
}

// Longer than one parallel chunk, with polygons at the front, in the middle and at the end.
TEST(Ply, TrianglesMixedWithPolygons) {
  constexpr int kFaces = 200000;
  for (const int polygon : {0, 1, 70000, 131072, kFaces - 1, kFaces}) {
    Bytes body = square();
    for (int i = 0; i < kFaces; ++i) {
      if (i == polygon) body.add(std::uint8_t{4}).add(0).add(1).add(2).add(3);
      if (i != polygon) body.add(std::uint8_t{3}).add(i % 4).add((i + 1) % 4).add((i + 2) % 4);
    }
    const Result<TriangleMesh> mesh = parse_text(header("binary_little_endian", kXyz, kList, 4, kFaces) + body.text());
    ASSERT_TRUE(mesh) << mesh.message();
    ASSERT_EQ(mesh->size(), kFaces + (polygon < kFaces ? 1u : 0u));
    for (int i = 0; i < kFaces; ++i) {
      if (i == polygon) continue;
      const IndexTriple& t = mesh->triangles[i + (i > polygon ? 1 : 0)];
      ASSERT_TRUE(t.v0 == i % 4u && t.v1 == (i + 1) % 4u && t.v2 == (i + 2) % 4u) << i;
    }
  }
}

TEST(Ply, NumbersThatAreNotFiniteAreKept) {
  const Result<TriangleMesh> mesh = parse_text(header("ascii", kXyz, kList, 2, 0) + "nan -inf 1e99\n1e-99 -1.5e0 +2\n");
  ASSERT_TRUE(mesh) << mesh.message();
  EXPECT_TRUE(std::isnan(mesh->vertices[0].x));
  EXPECT_EQ(mesh->vertices[0].y, -HUGE_VALF);
  EXPECT_EQ(mesh->vertices[0].z, HUGE_VALF);
  EXPECT_EQ(mesh->vertices[1], (Vec3{0, -1.5f, 2}));
}

TEST(Ply, ErrorsInTheHeader) {
  expect_ply_error("", "a.ply:1: a PLY file begins with the line 'ply'");
  expect_ply_error("plywood\n", "a.ply:1:");
  expect_ply_error("ply\nformat ascii 1.0\n", "a.ply:3: the header has no line 'end_header'");
  expect_ply_error("ply\nformat binary_middle_endian 1.0\n", "a.ply:2: 'binary_middle_endian' is not a PLY format");
  expect_ply_error("ply\nelement vertex -4\n", "a.ply:2: '-4' is not a count");
  expect_ply_error("ply\nelement vertex 99999999999999999999\n", "is not a count");
  expect_ply_error("ply\nproperty float x\n", "before the first element");
  expect_ply_error("ply\nelement vertex 1\nproperty quad x\n", "a.ply:3: 'quad' is not a PLY type");
  expect_ply_error("ply\nelement vertex 1\nproperty list float int x\n", "must be an integer");
  expect_ply_error("ply\nelement vertex 1\nproperty float x\nproperty float x\n", "a second property 'x'");
  expect_ply_error("ply\n\xff\xfe\x01\n", "a.ply:2: '\?\?\?' is not a statement");
  expect_ply_error("ply\nelement vertex 0\nend_header\n", "no line 'format'");
  expect_ply_error("ply\nformat ascii 1.0\nend_header\n", "has no element 'vertex'");
  expect_ply_error(header("ascii", "property float x\nproperty float y\n", kList), "has no number 'z'");
  expect_ply_error(header("ascii", kXyz, "property int material\n"), "has no list 'vertex_indices'");
  expect_ply_error(std::string("ply\nformat ascii 1.0\nelement vertex 0\n") + kXyz + "end_header\n", "point cloud");
  expect_ply_error("ply\n" + std::string(100000, 'x'), "a.ply:2");
  std::string endless = "ply\n";
  for (int i = 0; i < 20000; ++i) endless += "comment\n";
  expect_ply_error(endless, "too long");
}

TEST(Ply, ErrorsInTheBody) {
  const std::string ascii = header("ascii", kXyz, kList) + "0 0 5\n1 0 5\n1 1 5\n0 1 5\n";
  expect_ply_error(ascii + "3 0 1 2\n3 0 2 4\n", "a.ply:16: face 1: names vertex 4, but the file has 4");
  expect_ply_error(ascii + "3 0 1 2\n3 0 -1 2\n", "face 1: names vertex -1");
  expect_ply_error(ascii + "3 0 1 2\n3 0 1.5 2\n", "face 1: names vertex 1.5");
  expect_ply_error(ascii + "3 0 1 2\n-3 0 1 2\n", "face 1: has a list of negative or broken length");
  expect_ply_error(ascii + "3 0 1 2\n999999999 0 1 2\n", "face 1: has more corners");
  expect_ply_error(ascii + "3 0 1 2\n3 0 2\n", "face 1");
  expect_ply_error(ascii + "3 0 1 2\n3 0 2 +-3\n", "a.ply:16: face 1");
  expect_ply_error(header("ascii", kXyz, kList, 1, 0) + "0 1.2.3 5\n", "a.ply:11: vertex 0");
  expect_ply_error(header("ascii", kXyz, kList, 1, 0) + "0 5-2 5\n", "a.ply:11: vertex 0");
  expect_ply_error(ascii + "3 0 1 2\n3 0 2 x\n", "a.ply:16: face 1: the line or the file ends early, or no number stands here");
  expect_ply_error(header("ascii", kXyz, kList, 4000000000) + "0 0 0\n", "says that it has 4000000000 items");
  expect_ply_error(header("ascii", kXyz, kList, 5000000000) + "0 0 0\n", "more than 32 bits count");

  const std::string binary = header("binary_little_endian", kXyz, kList);
  const auto face = [](Bytes bytes, int length, int corner) {
    return bytes.add(static_cast<std::int8_t>(length)).add(0).add(1).add(corner).text();
  };
  expect_ply_error(binary + face(square(), 3, 2), "face 1 at byte");
  expect_ply_error(binary + face(square(), 3, 4) + std::string(13, '\0'), "face 0 at byte");
  expect_ply_error(binary + face(square(), 3, -7) + std::string(13, '\0'), "names vertex -7");
  expect_ply_error(binary + face(square(), 200, 2) + std::string(13, '\0'), "has more corners than the rest");
  expect_ply_error(header("binary_little_endian", kXyz, "property list char int vertex_indices\n") + face(square(), -3, 2) +
                       std::string(13, '\0'),
                   "negative");
  expect_ply_error(header("binary_little_endian", kXyz, kList, 4294967290u) + square().text(),
                   "items, but the file ends after");
  expect_ply_error(header("binary_little_endian", kXyz, kList, 4, 18446744073709551615u) + square().text(),
                   "18446744073709551615 items");
}

TEST(Ply, ItemsOfAsciiAreLines) {
  const std::string body = "\n0 0 5 \r\n1 0 5\t\r\n \r\n1 1 5\r\n0 1 5\r\n";
  expect_square(parse_text(header("ascii", kXyz, kList) + body + "3 0 1 2 \n\n3 0 2 3 \n \t\r\n\n"));

  const std::string square = header("ascii", kXyz, kList) + "0 0 5\n1 0 5\n1 1 5\n0 1 5\n";
  const std::string head = header("ascii", kXyz, kList);
  expect_ply_error(head + "0 0 5\n1 0\n1 1 5\n0 1 5\n3 0 1 2\n3 0 2 3\n",
                   "a.ply:12: vertex 1: the line or the file ends early");
  expect_ply_error(head + "0 0 5\n1 0 5 7\n1 1 5\n0 1 5\n3 0 1 2\n3 0 2 3\n", "a.ply:12: vertex 1: the line goes on");
  expect_ply_error(square + "3 0 1\n2\n3 0 2 3\n", "a.ply:15: face 0: the line or the file ends early");
  expect_ply_error(square + "3 0 1 2 3\n3 0 2 3\n", "a.ply:15: face 0: the line goes on");
  expect_ply_error(square + "3 0 1 2 3 0 2 3\n", "a.ply:15: face 0: the line goes on");

  const auto with_edges = [](std::string_view edges) {
    return header("ascii", kXyz, std::string(kList) + "element edge 2\nproperty int a\nproperty list uchar int b\n", 1, 0) +
           "0 0 0\n" + std::string(edges);
  };
  EXPECT_TRUE(parse_text(with_edges("1 2 8 9\r\n1 0"))) << parse_text(with_edges("1 2 8 9\r\n1 0")).message();
  expect_ply_error(with_edges("1 2 8\n9\n1 0"), "a.ply:15: edge 0: the line or the file ends early");
  expect_ply_error(with_edges("1 2 8 9 1\n1 0"), "a.ply:15: edge 0: the line goes on");
}

TEST(Ply, FacesWithoutTrianglesAreCounted) {
  std::uint64_t skipped = 0;
  const std::string ascii = header("ascii", kXyz, kList, 4, 3) + "0 0 5\n1 0 5\n1 1 5\n0 1 5\n2 0 1\n4 0 1 2 3\n0\n";
  expect_square(parse_ply(std::as_bytes(std::span(ascii)), "a.ply", {.skipped_faces = &skipped}));
  EXPECT_EQ(skipped, 2u);

  Bytes body = square();
  body.add(std::uint8_t{3}).add(0).add(1).add(2).add(std::uint8_t{1}).add(0).add(std::uint8_t{3}).add(0).add(2).add(3);
  const std::string binary = header("binary_little_endian", kXyz, kList, 4, 3) + body.text();
  expect_square(parse_ply(std::as_bytes(std::span(binary)), "a.ply", {.skipped_faces = &skipped}));
  EXPECT_EQ(skipped, 3u);
}

TEST(Ply, NothingFollowsTheLastElement) {
  expect_ply_error(header("ascii", kXyz, kList, 4, 1) + "0 0 5\n1 0 5\n1 1 5\n0 1 5\n3 0 1 2\n3 0 2 3\n",
                   "a.ply:16: after the last");
  expect_ply_error(header("ascii", kXyz, kList, 1, 0) + "0 0 5\n\n  end", "a.ply:13: after the last element: 3 bytes");
  for (const int faces : {1, 2}) {
    Bytes body = square();
    for (int i = 0; i < 2; ++i) body.add(std::uint8_t{3}).add(0).add(i + 1).add(i + 2);
    const std::string text = header("binary_little_endian", kXyz, kList, 4, faces) + body.text();
    if (faces == 1) expect_ply_error(text, "after the last element");
    if (faces == 2) expect_ply_error(text + "\n", "after the last element");
    if (faces == 2) expect_square(parse_text(text));
  }
}

// A file that ends anywhere, or has any byte changed, is an error or a mesh; never more.
TEST(Ply, EveryTruncationAndEveryByte) {
  Bytes body = square();
  body.add(std::uint8_t{3}).add(0).add(1).add(2).add(std::uint8_t{4}).add(0).add(1).add(2).add(3);
  const std::string texts[] = {header("binary_little_endian", kXyz, kList) + body.text(),
                               header("ascii", kXyz, kList) + "0 0 5\n1 0 5\n1 1 5\n0 1 5\n3 0 1 2\n4 0 1 2 3"};
  for (const std::string& text : texts) {
    ASSERT_TRUE(parse_text(text)) << parse_text(text).message();
    for (std::size_t size = 0; size < text.size(); ++size) {
      const std::string shorter = text.substr(0, size);
      const Result<TriangleMesh> mesh = parse_text(std::string_view(shorter));
      EXPECT_FALSE(mesh) << size;
    }
    for (std::size_t i = 0; i < text.size(); ++i) {
      for (const int change : {0x01, 0x10, 0x80, 0xff}) {
        std::string changed = text;
        changed[i] = static_cast<char>(changed[i] ^ change);
        const Result<TriangleMesh> mesh = parse_text(changed);
        EXPECT_TRUE(!mesh || validate(*mesh)) << i;
      }
    }
  }
}

TEST(Ply, CanBeInterrupted) {
  Bytes body = square();
  for (int i = 0; i < 2; ++i) body.add(std::uint8_t{3}).add(0).add(1).add(2);
  const std::string text = header("binary_little_endian", kXyz, kList) + body.text();
  const Result<TriangleMesh> mesh =
      parse_ply(std::as_bytes(std::span(text)), "a.ply", {[](std::string_view, double) { return false; }});
  ASSERT_FALSE(mesh);
  EXPECT_EQ(mesh.message(), kInterrupted);
}

}  // namespace
}  // namespace accel
