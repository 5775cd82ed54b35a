#include "libaccel/geometry/triangle_mesh.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <vector>

namespace accel {
namespace {

TEST(TriangleMesh, VerticesOfAnyStrideAndPrecision) {
  struct Vertex {
    float weight;
    double position[3];
    short tag;
  };
  const std::vector<Vertex> own = {{9, {1, 2, 3}, 8}, {9, {4, 5, 0.1}, 8}};
  const Buffer<Vec3> vertices = vertices_of(own[0].position, own.size(), sizeof(Vertex));
  ASSERT_EQ(vertices.size(), 2u);
  EXPECT_EQ(vertices[0], (Vec3{1, 2, 3}));
  EXPECT_EQ(vertices[1], (Vec3{4, 5, 0.1f}));

  const float packed[] = {1, 2, 3, 4, 5, 6};
  EXPECT_EQ(vertices_of(packed, 2)[1], (Vec3{4, 5, 6}));
  EXPECT_TRUE(vertices_of(packed, 0).empty());
}

}  // namespace
}  // namespace accel
