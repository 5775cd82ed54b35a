#include "libaccel/io/face_list.h"

#include <algorithm>

#include "libaccel/geometry/triangulate_polygon.h"

namespace accel {

void FaceList::add(std::span<const std::uint32_t> corners) {
  if (corners.size() < 3) {
    ++skipped_;
    return;
  }
  if (corners.size() != 3 && counts_.empty()) counts_.assign(corners_.size() / 3, 3);
  if (corners.size() != 3 || !counts_.empty()) counts_.push_back(static_cast<std::uint32_t>(corners.size()));
  corners_.insert(corners_.end(), corners.begin(), corners.end());
  triangles_ += corners.size() - 2;
}

Result<Buffer<IndexTriple>> FaceList::triangulate(const Buffer<IndexTriple>& first, std::span<const Vec3> vertices,
                                                  const std::string& name) const {
  const std::uint64_t count = first.size() + triangles_;
  if (count > kMaxTriangles)
    return Error{name + ": has " + std::to_string(count) + " triangles, more than the limit of " +
                 std::to_string(kMaxTriangles) + "; split it"};
  if (triangles_ == 0) return first;

  Buffer<IndexTriple> triangles(count);
  IndexTriple* out = std::copy(first.begin(), first.end(), triangles.begin());
  const std::uint32_t* corner = corners_.data();
  if (only_triangles()) {
    for (std::uint64_t i = 0; i < triangles_; ++i, corner += 3) *out++ = {corner[0], corner[1], corner[2]};
    return triangles;
  }

  PolygonTriangulator triangulator;
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    const std::span<const std::uint32_t> face(corner, counts_[i]);
    if (!triangulator.triangulate(face, vertices, out))
      return Error{name + ": a polygon that is not convex has " + std::to_string(face.size()) +
                   " corners, more than the limit of " + std::to_string(kMaxConcaveCorners) + "; triangulate it first"};
    corner += face.size(), out += face.size() - 2;
  }
  return triangles;
}

}  // namespace accel
