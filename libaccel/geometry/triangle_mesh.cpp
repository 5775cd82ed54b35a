#include "libaccel/geometry/triangle_mesh.h"

#include <algorithm>
#include <string>

namespace accel {

Status validate(const TriangleMesh& mesh) {
  if (mesh.size() > kMaxTriangles)
    return Error{"mesh has " + std::to_string(mesh.size()) + " triangles, more than the limit of " +
                 std::to_string(kMaxTriangles) + "; split it"};
  const std::size_t vertices = mesh.vertices.size();
  for (std::size_t i = 0; i < mesh.size(); ++i) {
    const IndexTriple& t = mesh.triangles[i];
    const std::uint32_t largest = std::max({t.v0, t.v1, t.v2});
    if (largest >= vertices)
      return Error{"triangle " + std::to_string(i) + " names vertex " + std::to_string(largest) + ", but the mesh has " +
                   std::to_string(vertices) + " vertices"};
  }
  return Done{};
}

}  // namespace accel
