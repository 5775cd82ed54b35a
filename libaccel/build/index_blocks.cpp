#include "libaccel/build/index_blocks.h"

#include <bit>
#include <cstdint>
#include <numeric>
#include <vector>

#include "libaccel/build/parallel.h"
#include "libaccel/build/radix_sort.h"

namespace accel {
namespace {

// Corners are numbered by block, lane and vertex: in the order in which tests read them.
constexpr std::uint32_t kCorners = 3 * kBlockLanes;

struct Bits {
  std::uint32_t x, y, z;

  bool operator==(const Bits&) const = default;
};

class Indexing {
 public:
  explicit Indexing(const Buffer<TriangleBlock>& blocks) : blocks_(blocks), size_(blocks.size() * kCorners), first_(size_) {}

  IndexedBlocks run() {
    find_first_corners();
    IndexedBlocks result;
    const Buffer<std::uint32_t> names = name_vertices(result.vertices);
    result.blocks = Buffer<IndexedBlock>(blocks_.size());
    for_chunks(0, blocks_.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
      for (std::size_t b = begin; b < end; ++b) result.blocks[b] = indexed(b, names);
    });
    return result;
  }

 private:
  Vec3 position(std::size_t corner) const {
    const TriangleBlock& block = blocks_[corner / kCorners];
    const std::size_t lane = corner % kCorners / 3, i = corner % 3;
    return {block.vertex[0][i][lane], block.vertex[1][i][lane], block.vertex[2][i][lane]};
  }
  Bits bits(std::size_t corner) const { return std::bit_cast<Bits>(position(corner)); }

  // Every bit of a coordinate has a part in the upper half of the products.
  static std::uint32_t hash(const Bits& p) {
    std::uint64_t h = 0;
    for (const std::uint32_t word : {p.x, p.y, p.z}) h = (std::rotl(h, 32) ^ word) * 0x9e3779b97f4a7c15u;
    return static_cast<std::uint32_t>(h >> 32);
  }

  // For each corner, the first one that is at the same place.
  void find_first_corners() {
    Buffer<std::uint32_t> hashes(size_), corners(size_);
    for_chunks(0, size_, [&](std::size_t, std::size_t begin, std::size_t end) {
      for (std::size_t c = begin; c < end; ++c) hashes[c] = hash(bits(c)), corners[c] = static_cast<std::uint32_t>(c);
    });
    radix_sort(hashes.data(), corners.data(), size_);
    // Runs of equal hashes, by the chunk that they begin in.
    for_chunks(0, size_, [&](std::size_t, std::size_t begin, std::size_t end) {
      std::size_t at = begin;
      while (at > 0 && at < end && hashes[at] == hashes[at - 1]) ++at;
      for (std::size_t last; at < end; at = last) {
        for (last = at + 1; last < size_ && hashes[last] == hashes[at];) ++last;
        merge(corners.data() + at, corners.data() + last);
      }
    });
  }

  // Corners of one hash, in order: nearly always of one place.
  void merge(const std::uint32_t* begin, const std::uint32_t* end) {
    std::vector<std::uint32_t> others;  // first ones, of other places than the first of all
    const Bits place = bits(*begin);
    for (const std::uint32_t* corner = begin; corner != end; ++corner)
      first_[*corner] = bits(*corner) == place ? *begin : first_of(*corner, others);
  }
  std::uint32_t first_of(std::uint32_t corner, std::vector<std::uint32_t>& others) const {
    for (const std::uint32_t other : others)
      if (bits(other) == bits(corner)) return other;
    others.push_back(corner);
    return corner;
  }

  // The vertices, and at each first corner the number of its vertex.
  Buffer<std::uint32_t> name_vertices(Buffer<Vec3>& vertices) const {
    std::vector<std::uint32_t> next(chunk_count(size_));
    for_chunks(0, size_, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
      for (std::size_t c = begin; c < end; ++c) next[chunk] += first_[c] == c ? 1 : 0;
    });
    const std::size_t count = std::accumulate(next.begin(), next.end(), std::size_t{0});
    std::exclusive_scan(next.begin(), next.end(), next.begin(), 0u);
    Buffer<std::uint32_t> names(size_);
    vertices = Buffer<Vec3>(size_ == 0 ? 0 : count + 1);
    for_chunks(0, size_, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
      for (std::size_t c = begin; c < end; ++c)
        if (first_[c] == c) vertices[next[chunk]] = position(c), names[c] = next[chunk]++;
    });
    if (count != 0) vertices[count] = {};
    return names;
  }

  IndexedBlock indexed(std::size_t b, const Buffer<std::uint32_t>& names) const {
    IndexedBlock block;
    for (std::uint32_t lane = 0; lane < kBlockLanes; ++lane) {
      for (std::uint32_t i = 0; i < 3; ++i) block.vertex[i][lane] = names[first_[b * kCorners + 3 * lane + i]];
      block.prim_id[lane] = blocks_[b].prim_id[lane];
    }
    return block;
  }

  const Buffer<TriangleBlock>& blocks_;
  const std::size_t size_;
  Buffer<std::uint32_t> first_;
};

}  // namespace

IndexedBlocks index_blocks(const Buffer<TriangleBlock>& blocks) { return Indexing(blocks).run(); }

}  // namespace accel
