// A triangle mesh: shared vertex positions and three indices a triangle. The number of a triangle is its prim_id everywhere.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "libaccel/core/aabb.h"
#include "libaccel/core/buffer.h"
#include "libaccel/core/result.h"
#include "libaccel/core/vec3.h"

namespace accel {

// Vertex indices of one triangle.
struct IndexTriple {
  std::uint32_t v0, v1, v2;
};

// Vertex positions of one triangle.
struct Triangle {
  Vec3 v0, v1, v2;

  ACCEL_HD Aabb bounds() const {
    Aabb box;
    box.extend(v0), box.extend(v1), box.extend(v2);
    return box;
  }
};

// Copies share their arrays: core/buffer.h.
struct TriangleMesh {
  Buffer<Vec3> vertices;
  Buffer<IndexTriple> triangles;

  std::size_t size() const { return triangles.size(); }
  std::size_t size_bytes() const { return vertices.size_bytes() + triangles.size_bytes(); }

  Triangle triangle(std::size_t prim_id) const {
    const IndexTriple& t = triangles[prim_id];
    return {vertices[t.v0], vertices[t.v1], vertices[t.v2]};
  }
};

// Vertices as an application has them: `count` points of three floats or doubles, which are rounded, each so many bytes behind
// the one before.
template <class T>
Buffer<Vec3> vertices_of(const T* first, std::size_t count, std::size_t stride_bytes = 3 * sizeof(T)) {
  Buffer<Vec3> result(count);
  const auto* const bytes = reinterpret_cast<const std::byte*>(first);
  for (std::size_t i = 0; i < count; ++i) {
    T point[3];
    std::memcpy(point, bytes + i * stride_bytes, sizeof point);
    result[i] = {static_cast<float>(point[0]), static_cast<float>(point[1]), static_cast<float>(point[2])};
  }
  return result;
}

// The number of triangles a mesh may have: prim_id 0xffffffff means a miss, and leaf streams are indexed with 31 bits.
inline constexpr std::uint64_t kMaxTriangles = 1ull << 29;

// Whether every index is in range and the triangle count is within kMaxTriangles. Positions may hold anything.
Status validate(const TriangleMesh& mesh);

}  // namespace accel
