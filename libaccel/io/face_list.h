// Faces as they come out of a file, and their triangles.
//
// Readers add faces in file order, before or after the vertices are known; triangulate() then gives all triangles in that
// order.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "libaccel/geometry/triangle_mesh.h"

namespace accel {

class FaceList {
 public:
  // Adds a face. One with fewer than three corners has no triangles, and is only counted.
  void add(std::span<const std::uint32_t> corners);

  std::uint64_t triangle_count() const { return triangles_; }
  std::uint64_t skipped() const { return skipped_; }
  bool only_triangles() const { return counts_.empty(); }

  // The triangles of `first`, then those of the faces; every corner is less than vertices.size(). Errors begin with `name`, the
  // file's.
  Result<Buffer<IndexTriple>> triangulate(const Buffer<IndexTriple>& first, std::span<const Vec3> vertices,
                                          const std::string& name) const;

 private:
  std::vector<std::uint32_t> corners_;
  std::vector<std::uint32_t> counts_;  // corners of each face; empty as long as all have three
  std::uint64_t triangles_ = 0;
  std::uint64_t skipped_ = 0;
};

}  // namespace accel
