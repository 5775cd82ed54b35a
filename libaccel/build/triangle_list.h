// Builds no hierarchy: all triangles that a ray can hit, in mesh order.
#pragma once

#include "libaccel/build/builder.h"
#include "libaccel/structure/triangle_list.h"

namespace accel {

struct ListBuilder {
  static constexpr const char* kName = "brute";
  using Structure = TriangleList;
  static Result<Built<TriangleList>> build(const TriangleMesh& mesh, const BuildOptions& options);
};

}  // namespace accel
