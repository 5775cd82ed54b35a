// Hash values of rays: equal ones belong to rays that start near each other and go the same way, so that sorting by them makes
// neighbours of coherent rays. Garanzha and Loop 2010 [GL10], section 3.1.
//
// A virtual grid of cubical cells quantises the origin (cell size = fraction x diagonal of the scene's box, section 4), and a
// grid on each face of the unit cube the direction. Deviations: the face, dominant axis and sign, is part of the value, so that
// no packet of equal values mixes dominant axes; cells are numbered along Z-curves, so that values that follow each other are
// near each other, too; 64 bits are offered, where far cells of grids with up to 2^16 cells a side never share a value. In 32
// bits they may: that is slow, not wrong.
//
//   bits:   32 bits: 8 bits of the cell for each axis (modulo 256), 3 of the face, 2 + 2 within the face
//           64 bits: 16 bits of the cell for each axis, 3 of the face, 6 + 6 within the face
//           64 bits, fine directions: 12 bits of the cell for each axis, 3 of the face, 12 + 12 within the face: rays of one
//           origin come along a Z-curve, as [GL10] sorts primary rays
//
// Values are defined for all rays, NaN included.
#pragma once

#include <cmath>
#include <cstdint>

#include "libaccel/core/aabb.h"
#include "libaccel/core/morton.h"
#include "libaccel/core/ray.h"

namespace accel {

inline constexpr int kFineDirectionBits = 12;

template <class Key, int kBitsOfDirection = sizeof(Key) == 8 ? 6 : 2>
struct RayHash {
  static constexpr int kDirectionBits = kBitsOfDirection;                               // an axis of a face
  static constexpr int kOriginBits = (8 * sizeof(Key) - 3 - 2 * kBitsOfDirection) / 3;  // an axis

  Vec3 lo;                    // of the grid
  float cells = 0;            // per unit of length
  bool origins_only = false;  // [GL10], section 4, sorts soft-shadow rays so

  // `cell_fraction`: of the box's diagonal. Boxes that are empty or a point make one cell.
  static RayHash make(const Aabb& bounds, float cell_fraction, bool origins_only = false) {
    RayHash hash{.origins_only = origins_only};
    if (bounds.empty()) return hash;
    const Vec3 e = bounds.extent();
    const double diagonal =
        std::sqrt(static_cast<double>(e.x) * e.x + static_cast<double>(e.y) * e.y + static_cast<double>(e.z) * e.z);
    hash.lo = bounds.lo;
    const double cells = 1.0 / (diagonal * cell_fraction);
    hash.cells = std::isfinite(cells) ? static_cast<float>(cells) : 0.0f;
    return hash;
  }

  ACCEL_HD Key operator()(const Ray& ray) const {
    const auto cell = morton_3d(cell_of(ray.org.x - lo.x), cell_of(ray.org.y - lo.y), cell_of(ray.org.z - lo.z));
    if (origins_only) return static_cast<Key>(cell);
    const int axis = largest_axis(ray.dir);
    const float along = ray.dir[axis], scale = 1.0f / (along < 0 ? -along : along);
    const std::uint32_t face = 2u * static_cast<std::uint32_t>(axis) + (along < 0 ? 1u : 0u);
    const auto within =
        morton_2d(face_cell_of(ray.dir[axis == 0 ? 1 : 0] * scale), face_cell_of(ray.dir[axis == 2 ? 1 : 2] * scale));
    return static_cast<Key>((cell << 3 | face) << 2 * kDirectionBits | within);
  }

 private:
  // Outside of the grid the last cell counts, with 64 bits, or the cells repeat.
  ACCEL_HD std::uint32_t cell_of(float offset) const {
    constexpr std::uint32_t kLast = (1u << kOriginBits) - 1;
    constexpr float kMost = sizeof(Key) == 8 ? static_cast<float>(kLast) : 16777215.0f;
    const float cell = offset * cells;
    if (!(cell > 0)) return 0;
    return static_cast<std::uint32_t>(cell < kMost ? cell : kMost) & kLast;
  }
  // Of a coordinate in [-1, 1]; in floats, since nothing but the speed depends on where cells end.
  ACCEL_HD static std::uint32_t face_cell_of(float x) {
    constexpr float kCells = static_cast<float>(1 << kDirectionBits);
    const float cell = (x + 1) * (kCells / 2);
    if (!(cell > 0)) return 0;
    return static_cast<std::uint32_t>(cell < kCells - 1 ? cell : kCells - 1);
  }
};

}  // namespace accel
