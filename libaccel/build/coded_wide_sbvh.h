// Builds a Bvh8 with coded boxes: WideSbvh's (build/wide_sbvh.h), coded (build/code_bvh8.h); or, with leaves that name vertices
// too, a compact one.
#pragma once

#include "libaccel/build/builder.h"
#include "libaccel/structure/bvh8_coded.h"

namespace accel {

struct ByteWideSbvh {
  static constexpr const char* kName = ByteBvh8Node::kKind;
  using Structure = Bvh8Byte;
  static Result<Built<Bvh8Byte>> build(const TriangleMesh& mesh, const BuildOptions& options);
};

struct HalfWideSbvh {
  static constexpr const char* kName = HalfBvh8Node::kKind;
  using Structure = Bvh8Half;
  static Result<Built<Bvh8Half>> build(const TriangleMesh& mesh, const BuildOptions& options);
};

struct CompactWideSbvh {
  static constexpr const char* kName = CompactBvh8Node::kKind;
  using Structure = Bvh8Compact;
  static Result<Built<Bvh8Compact>> build(const TriangleMesh& mesh, const BuildOptions& options);
};

}  // namespace accel
