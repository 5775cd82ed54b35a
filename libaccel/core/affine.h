// Affine maps of space: p -> M p + T, as three rows of four floats, the translation last.
//
// A ray is taken through the inverse of the map that places an object, and keeps its t, because its direction is not made a
// unit vector. The inverse is kept as L = M^-1 and T itself, and a point goes to L (p - T): the difference is taken first, so
// that errors grow with the distance of p from T and not with the size of coordinates. With u = 2^-24 and |e| <= u for every
// rounding (of the difference, of an entry of L, of a product, of two sums),
//
//   | L^(p - T) - L (p - T) |_i <= gamma(5) sum_j |L_ij| |p_j - T_j|      for a point (kInverseRoundings = 5),
//   | L^ d - L d |_i            <= gamma(4) sum_j |L_ij| |d_j|            for a vector,
//
// but for underflow. The identity rounds nothing: points and vectors keep their bits (but for the sign of a zero).
//
// The inverse is computed in double. A cofactor's two products of floats are exact there, so it is off by one rounding; the
// determinant, a sum of three products, by at most 4 * 2^-53 of the sum of their magnitudes. Maps whose determinant is not
// above kLeastDeterminant times that sum count as singular, so that entries of L have a relative error of at most 2^-34 before
// they are rounded to floats: the bounds above have room for it, as rounding in double is in gamma(n) for no n.
#pragma once

#include <cmath>
#include <numbers>
#include <string>
#include <type_traits>

#include "libaccel/core/ray.h"
#include "libaccel/core/result.h"
#include "libaccel/core/vec3d.h"

namespace accel {

inline constexpr int kInverseRoundings = 5;
inline constexpr double kLeastDeterminant = 0x1p-16;

struct Affine {
  float m[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};

  Vec3 translation() const { return {m[0][3], m[1][3], m[2][3]}; }
  bool operator==(const Affine&) const = default;
};
static_assert(sizeof(Affine) == 48 && std::is_trivially_copyable_v<Affine>, "files rely on this layout");

// Where a point goes. Products of floats are exact in double, so the error is at most 4 * 2^-53 of the sum of the magnitudes
// that are added.
inline Vec3d transform_point(const Affine& a, Vec3d p) {
  const auto row = [&](const float(&r)[4]) { return r[0] * p.x + r[1] * p.y + r[2] * p.z + r[3]; };
  return {row(a.m[0]), row(a.m[1]), row(a.m[2])};
}

// Scales along the axes, then turns about an axis through the origin, which is not zero, then moves. Computed in double.
inline Affine placed_by(Vec3 scale, Vec3 axis, double degrees, Vec3 translation) {
  const double angle = degrees * (std::numbers::pi / 180), c = std::cos(angle), s = std::sin(angle);
  const Vec3d k = normalized(Vec3d(axis));
  const double turn[3][3] = {{c + k.x * k.x * (1 - c), k.x * k.y * (1 - c) - k.z * s, k.x * k.z * (1 - c) + k.y * s},
                             {k.y * k.x * (1 - c) + k.z * s, c + k.y * k.y * (1 - c), k.y * k.z * (1 - c) - k.x * s},
                             {k.z * k.x * (1 - c) - k.y * s, k.z * k.y * (1 - c) + k.x * s, c + k.z * k.z * (1 - c)}};
  Affine result;
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b) result.m[a][b] = static_cast<float>(turn[a][b] * scale[b]);
    result.m[a][3] = translation[a];
  }
  return result;
}

// The inverse of an Affine, as rays are taken through it.
struct AffineInverse {
  float linear[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  Vec3 origin;  // where the map takes (0, 0, 0)

  ACCEL_HD Vec3 vector(Vec3 v) const {
    return {linear[0][0] * v.x + linear[0][1] * v.y + linear[0][2] * v.z,
            linear[1][0] * v.x + linear[1][1] * v.y + linear[1][2] * v.z,
            linear[2][0] * v.x + linear[2][1] * v.y + linear[2][2] * v.z};
  }
  ACCEL_HD Vec3 point(Vec3 p) const { return vector(p - origin); }

  // The same points at the same t.
  ACCEL_HD Ray ray(const Ray& r) const { return {point(r.org), r.t_min, vector(r.dir), r.t_max}; }
};
static_assert(sizeof(AffineInverse) == 48 && std::is_trivially_copyable_v<AffineInverse>, "structures rely on this layout");

inline bool is_finite(const AffineInverse& map) {
  bool finite = std::isfinite(map.origin.x) && std::isfinite(map.origin.y) && std::isfinite(map.origin.z);
  for (const auto& row : map.linear)
    for (const float x : row) finite = finite && std::isfinite(x);
  return finite;
}

// The inverse of the linear part in double, with a relative error of 2^-34 at most in every entry.
struct LinearInverse {
  double m[3][3];
};

// Errors, worded to follow the name of what has the map: an entry that is not finite or out of range, no inverse or none in
// range.
inline Result<LinearInverse> invert_linear(const Affine& a) {
  for (const auto& row : a.m)
    for (const float x : row)
      if (!(std::fabs(x) <= kMaxCoordinate)) return Error{"has a number that is not finite or too large"};
  double cofactor[3][3];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      cofactor[i][j] = double{a.m[i1][j1]} * a.m[i2][j2] - double{a.m[i1][j2]} * a.m[i2][j1];
    }
  double det = 0, magnitudes = 0;
  for (int j = 0; j < 3; ++j) det += a.m[0][j] * cofactor[0][j], magnitudes += std::fabs(a.m[0][j] * cofactor[0][j]);
  if (!(std::fabs(det) > kLeastDeterminant * magnitudes))
    return Error{"is singular, or too nearly so: it has no inverse that floats can hold"};
  LinearInverse inverse;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      inverse.m[i][j] = cofactor[j][i] / det;
      if (!(std::fabs(inverse.m[i][j]) <= kMaxCoordinate)) return Error{"shrinks so much that its inverse is out of range"};
    }
  return inverse;
}

inline Result<AffineInverse> inverse(const Affine& a) {
  const Result<LinearInverse> linear = invert_linear(a);
  if (!linear) return linear.error();
  AffineInverse result;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) result.linear[i][j] = static_cast<float>(linear->m[i][j]);
  result.origin = a.translation();
  return result;
}

}  // namespace accel
