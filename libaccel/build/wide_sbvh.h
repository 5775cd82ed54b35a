// Builds a Bvh8: the tree of Sbvh (build/sbvh.h), collapsed at the least cost (build/collapse_wide.h).
#pragma once

#include "libaccel/build/builder.h"
#include "libaccel/structure/bvh8.h"

namespace accel {

struct WideSbvh {
  static constexpr const char* kName = "bvh8";
  using Structure = Bvh8;
  static Result<Built<Bvh8>> build(const TriangleMesh& mesh, const BuildOptions& options);
};

}  // namespace accel
