// The transforms of a glTF file's nodes (glTF 2.0, section 3.5.3).
#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "libaccel/core/affine.h"
#include "libaccel/core/vec3d.h"
#include "libaccel/io/json_cursor.h"

namespace accel {

// An affine map in double: the maps of nodes are multiplied along their paths.
struct NodeMap {
  double m[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};

  Vec3d vector(Vec3d v) const {
    const auto row = [&](const double(&r)[4]) { return r[0] * v.x + r[1] * v.y + r[2] * v.z; };
    return {row(m[0]), row(m[1]), row(m[2])};
  }
  // Whether it takes everything to one point.
  bool is_point() const {
    return std::all_of(m, m + 3, [](const auto& row) { return row[0] == 0 && row[1] == 0 && row[2] == 0; });
  }
  Vec3d translation() const { return {m[0][3], m[1][3], m[2][3]}; }
  Affine rounded() const {
    Affine result;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 4; ++j) result.m[i][j] = static_cast<float>(m[i][j]);
    return result;
  }
};

inline NodeMap operator*(const NodeMap& a, const NodeMap& b) {
  NodeMap result;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 4; ++j) {
      result.m[i][j] = j == 3 ? a.m[i][3] : 0;
      for (int k = 0; k < 3; ++k) result.m[i][j] += a.m[i][k] * b.m[k][j];
    }
  return result;
}

// Scales, turns by a quaternion (x, y, z, w) of any length but zero, then moves.
inline NodeMap placed_by(std::span<const double> shift, std::span<const double> turn, std::span<const double> scale) {
  const double length = std::hypot(std::hypot(turn[0], turn[1]), std::hypot(turn[2], turn[3]));
  const double x = turn[0] / length, y = turn[1] / length, z = turn[2] / length, w = turn[3] / length;
  const double r[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
                          {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
                          {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}};
  NodeMap map;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) map.m[i][j] = r[i][j] * scale[j];
    map.m[i][3] = shift[i];
  }
  return map;
}

inline bool is_zero(std::span<const double> turn) {
  return std::all_of(turn.begin(), turn.end(), [](double x) { return x == 0; });
}

// Of a node of the document, which has a matrix by columns, or a scale, a rotation and a translation.
inline NodeMap map_of(const JsonCursor& node) {
  if (const auto matrix = node.find("matrix")) {
    const std::vector<double> columns = matrix->numbers(16);
    NodeMap map;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 4; ++j) map.m[i][j] = columns[4 * j + i];
    if (columns[3] != 0 || columns[7] != 0 || columns[11] != 0 || columns[15] != 1)
      matrix->fail("is not affine: its last row must be 0 0 0 1");
    return map;
  }
  const auto numbers_or = [&](const char* key, std::vector<double> otherwise) {
    const auto given = node.find(key);
    return given ? given->numbers(otherwise.size()) : otherwise;
  };
  const std::vector<double> turn = numbers_or("rotation", {0, 0, 0, 1});
  if (is_zero(turn)) node["rotation"].fail("must not be zero");
  return placed_by(numbers_or("translation", {0, 0, 0}), turn, numbers_or("scale", {1, 1, 1}));
}

}  // namespace accel
