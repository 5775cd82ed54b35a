// The triangles of a block, as the tests take them: of a block that names vertices (structure/indexed_block.h) they are fetched
// and turned into coordinates by lane, in memory, since which axis is the test's first depends on the ray. The guard lets the
// header through once for each target that Highway compiles.
#if defined(ACCEL_INDEXED_BLOCK_SIMD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ACCEL_INDEXED_BLOCK_SIMD_INL_H
#undef ACCEL_INDEXED_BLOCK_SIMD_INL_H
#else
#define ACCEL_INDEXED_BLOCK_SIMD_INL_H
#endif

#include <hwy/highway.h>

#include <cstdint>

#include "libaccel/structure/bvh8.h"
#include "libaccel/trace/triangle_block_simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace accel {
namespace HWY_NAMESPACE {
namespace {

// Vertex i of each triangle.
HWY_INLINE void fetch_vertices(const IndexedBlock& block, int i, const Vec3* vertices, TriangleBlock& to) {
  const std::uint32_t* const names = block.vertex[i];
#if HWY_TARGET == HWY_SCALAR
  for (std::uint32_t lane = 0; lane < kBlockLanes; ++lane)
    for (int a = 0; a < 3; ++a) to.vertex[a][i][lane] = vertices[names[lane]][a];
#else
  static_assert(sizeof(Vec3) == 12 && kBlockLanes == 4);
  const auto load = [&](std::uint32_t lane) HWY_ATTR { return hn::LoadU(kTriangles, &vertices[names[lane]].x); };
  const Triangles v0 = load(0), v1 = load(1), v2 = load(2), v3 = load(3);
  // x0 x2 y0 y2, x1 x3 y1 y3; and z likewise, with what lies behind.
  const Triangles even = hn::InterleaveLower(kTriangles, v0, v2), odd = hn::InterleaveLower(kTriangles, v1, v3);
  const Triangles even_z = hn::InterleaveUpper(kTriangles, v0, v2), odd_z = hn::InterleaveUpper(kTriangles, v1, v3);
  hn::Store(hn::InterleaveLower(kTriangles, even, odd), kTriangles, to.vertex[0][i]);
  hn::Store(hn::InterleaveUpper(kTriangles, even, odd), kTriangles, to.vertex[1][i]);
  hn::Store(hn::InterleaveLower(kTriangles, even_z, odd_z), kTriangles, to.vertex[2][i]);
#endif
}

// Makes room for the triangles of a block that names their vertices; other blocks have them.
template <class Node>
HWY_INLINE void fetch_triangles([[maybe_unused]] const Bvh8ViewOf<Node>& view, const typename Node::Block& block,
                                [[maybe_unused]] TriangleBlock& room) {
  if constexpr (Node::Block::kIsIndexed) {
    for (int i = 0; i < 3; ++i) fetch_vertices(block, i, view.vertices, room);
    for (std::uint32_t lane = 0; lane < kBlockLanes; ++lane) room.prim_id[lane] = block.prim_id[lane];
  }
}

// Where the triangles are then.
HWY_INLINE const TriangleBlock& fetched(const TriangleBlock& block, const TriangleBlock&) { return block; }
HWY_INLINE const TriangleBlock& fetched(const IndexedBlock&, const TriangleBlock& room) { return room; }

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace accel
HWY_AFTER_NAMESPACE();

#endif
