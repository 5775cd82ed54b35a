// The order in which a block of rays is cut into packets: faces (packet/frustum.h) one after the other, and within a face the
// rays as they come, or sorted by hash values (packet/ray_hash.h). Garanzha and Loop 2010 [GL10], section 3.1.
//
// [GL10] sorts runs of rays with equal hash values as one. Here a run has a given number of rays, whatever their values, and is
// sorted by the value of the ray in its middle: a picture's rows are cut into short pieces, and pieces below each other make a
// packet, for a fraction of what it costs to hash and to sort rays. Of the values, the highest kKeyBits count in which those of
// a block differ. Where rows can be told (packet/pixel_rows.h), tiles of them are listed instead, without values or sorting.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "libaccel/core/aabb.h"
#include "libaccel/core/ray.h"
#include "libaccel/packet/frustum.h"
#include "libaccel/packet/ray_hash_simd.h"

namespace accel {

// To choose an order by the widths of frustums: the size of the packets that have them, and what runs cost, as a factor.
inline constexpr std::uint32_t kComparedSize = 64;
inline constexpr double kCostOfRuns = 1.1;

class BlockOrder {
 public:
  static constexpr int kKeyBits = 24;

  BlockOrder(const Aabb& bounds, float cell_fraction)
      : hash_(FineRayHash::make(bounds, cell_fraction)), inv_diagonal_(FineRayHash::make(bounds, 1).cells) {}

  // Fewer than 2^32 rays, which are read by later calls too.
  void begin(std::span<const Ray> rays);
  // By tiles of pixels' rows, else by runs of so many rays; or as they come for 0.
  void sort(std::uint32_t run);
  // Drops all rays but those at the places [first, end) of the pairs, which ascend.
  void keep(std::span<const std::pair<std::uint32_t, std::uint32_t>> places);

  // ids()[i] is the ray that comes i-th, faces()[i] its face.
  std::span<const std::uint32_t> ids() const { return ids_; }
  std::span<const std::uint8_t> faces() const { return faces_; }

 private:
  void sort_runs(std::uint32_t run);
  template <class ForEachRun>
  void place_runs(std::size_t run, const ForEachRun& for_each_run);

  FineRayHash hash_;
  float inv_diagonal_;  // of the scene
  std::span<const Ray> rays_;
  std::vector<std::uint8_t> faces_by_ray_, faces_;
  std::vector<std::uint64_t> values_;  // of runs, as are keys_
  std::vector<std::uint32_t> keys_, runs_, ids_;
};

}  // namespace accel
