#include "libaccel/build/index_blocks.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <array>
#include <cstring>
#include <set>
#include <vector>

#include "validation/unit/build/test_meshes.h"

namespace accel {
namespace {

using Position = std::array<std::uint32_t, 3>;

Position bits_of(const Vec3& v) {
  Position bits;
  std::memcpy(bits.data(), &v, sizeof bits);
  return bits;
}

// Blocks of the triangles in order, some with lanes left over.
Buffer<TriangleBlock> blocks_of(const TriangleMesh& mesh) {
  std::vector<TriangleBlock> blocks;
  for (std::uint32_t id = 0; id < mesh.size();) {
    const std::uint32_t count = blocks.size() % 3 == 0 ? 4 : blocks.size() % 5 % 4;
    TriangleBlock block;
    for (std::uint32_t lane = 0; lane < kBlockLanes; ++lane)
      if (lane < count && id < mesh.size()) {
        block.set(lane, pack(mesh.triangle(id), id)), ++id;
      } else {
        block.clear(lane);
      }
    blocks.push_back(block);
  }
  return Buffer<TriangleBlock>::copy_of(blocks);
}

void expect_same_triangles(const Buffer<TriangleBlock>& blocks, const IndexedBlocks& indexed) {
  ASSERT_EQ(indexed.blocks.size(), blocks.size());
  for (std::size_t b = 0; b < blocks.size(); ++b)
    for (std::uint32_t lane = 0; lane < kBlockLanes; ++lane) {
      for (const auto& vertex : indexed.blocks[b].vertex) ASSERT_LT(vertex[lane] + 1, indexed.vertices.size());
      const PackedTriangle expected = blocks[b].packed(lane);
      const PackedTriangle triangle = indexed.blocks[b].packed(lane, indexed.vertices.data());
      ASSERT_EQ(std::memcmp(&triangle, &expected, sizeof triangle), 0) << "block " << b << ", lane " << lane;
    }
}

// Each vertex once, and numbered as tests come to them; the last is named by none.
void expect_in_order_of_use(const IndexedBlocks& indexed) {
  std::set<Position> seen;
  std::uint32_t next = 0;
  for (const IndexedBlock& block : indexed.blocks)
    for (std::uint32_t lane = 0; lane < kBlockLanes; ++lane)
      for (const auto& vertex : block.vertex) {
        ASSERT_LE(vertex[lane], next);
        if (vertex[lane] < next) continue;
        ++next;
        EXPECT_TRUE(seen.insert(bits_of(indexed.vertices[vertex[lane]])).second) << "twice: " << vertex[lane];
      }
  EXPECT_EQ(indexed.vertices.size(), indexed.blocks.empty() ? 0u : next + 1);
}

TEST(IndexBlocks, TrianglesKeepTheirBits) {
  for (const auto& [name, mesh] : test::all_meshes()) {
    SCOPED_TRACE(name);
    const Buffer<TriangleBlock> blocks = blocks_of(mesh);
    const IndexedBlocks indexed = index_blocks(blocks);
    expect_same_triangles(blocks, indexed);
    expect_in_order_of_use(indexed);
  }
}

// A million positions have hashes of 32 bits in common: a hundred pairs, about.
TEST(IndexBlocks, PositionsWithOneHashAreKeptApart) {
  const Buffer<TriangleBlock> blocks = blocks_of(test::soup(330'000, 0.5f));
  expect_same_triangles(blocks, index_blocks(blocks));
}

// Corners of one place that fill more than a chunk, beside others.
TEST(IndexBlocks, ManyCornersOfOneVertex) {
  std::vector<Triangle> fan;
  for (int i = 0; i < 20'000; ++i) {
    const auto x = static_cast<float>(i);
    fan.push_back({{0, 0, 0}, {x, 1, 0}, {x + 1, 1, 0}});
  }
  const Buffer<TriangleBlock> blocks = blocks_of(test::mesh_of(fan));
  const IndexedBlocks indexed = index_blocks(blocks);
  expect_same_triangles(blocks, indexed);
  expect_in_order_of_use(indexed);
  EXPECT_EQ(indexed.vertices.size(), 1u + 20'001 + 2);  // one is NaN, and one to be read over
}

TEST(IndexBlocks, ZerosOfBothSigns) {
  const Buffer<TriangleBlock> blocks =
      blocks_of(test::mesh_of({{{0, 0, 0}, {-0.0f, 0, 0}, {0, 0, -0.0f}}, {{0, 0, -0.0f}, {0, 0, 0}, {1, 0, 0}}}));
  const IndexedBlocks indexed = index_blocks(blocks);
  expect_same_triangles(blocks, indexed);
  EXPECT_EQ(indexed.vertices.size(), 4u + 2);
}

TEST(IndexBlocks, Nothing) {
  const IndexedBlocks indexed = index_blocks({});
  EXPECT_TRUE(indexed.blocks.empty());
  EXPECT_TRUE(indexed.vertices.empty());
}

TEST(IndexBlocks, TheSameForAnyThreads) {
  const tbb::global_control more_threads(tbb::global_control::max_allowed_parallelism, 8);
  const Buffer<TriangleBlock> blocks = blocks_of(test::flat_grid(150));
  const auto in_threads = [&](int threads) { return tbb::task_arena(threads).execute([&] { return index_blocks(blocks); }); };
  const IndexedBlocks one = in_threads(1);
  for (const int threads : {2, 3, 8}) {
    const IndexedBlocks many = in_threads(threads);
    ASSERT_EQ(many.vertices.size(), one.vertices.size());
    EXPECT_EQ(std::memcmp(many.vertices.data(), one.vertices.data(), one.vertices.size_bytes()), 0);
    EXPECT_EQ(std::memcmp(many.blocks.data(), one.blocks.data(), one.blocks.size_bytes()), 0);
  }
}

}  // namespace
}  // namespace accel
