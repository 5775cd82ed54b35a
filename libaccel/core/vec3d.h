// Three doubles: for what is computed once and rounded to floats at the end (cameras, surface points, scene generators).
//
// Differences and products of floats are exact or nearly so in double, and no length of a float vector over- or underflows.
#pragma once

#include <cmath>

#include "libaccel/core/vec3.h"

namespace accel {

struct Vec3d {
  double x = 0.0, y = 0.0, z = 0.0;

  Vec3d() = default;
  constexpr Vec3d(double x_value, double y_value, double z_value) : x(x_value), y(y_value), z(z_value) {}
  explicit constexpr Vec3d(Vec3 v) : x(v.x), y(v.y), z(v.z) {}

  // Rounded to the nearest floats.
  Vec3 to_float() const { return {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)}; }
};

constexpr Vec3d operator+(Vec3d a, Vec3d b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
constexpr Vec3d operator-(Vec3d a, Vec3d b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
constexpr Vec3d operator-(Vec3d a) { return {-a.x, -a.y, -a.z}; }
constexpr Vec3d operator*(Vec3d a, double s) { return {a.x * s, a.y * s, a.z * s}; }
constexpr Vec3d operator*(double s, Vec3d a) { return a * s; }

constexpr double dot(Vec3d a, Vec3d b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
constexpr Vec3d cross(Vec3d a, Vec3d b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
inline double length(Vec3d v) { return std::sqrt(dot(v, v)); }

// The vector of length 1 in the direction of v; NaN for the zero vector.
inline Vec3d normalized(Vec3d v) { return v * (1.0 / length(v)); }

// Two unit vectors that form a right-handed orthonormal basis with the unit vector n: Duff et al. 2017, "Building an
// Orthonormal Basis, Revisited", JCGT 6(1).
inline void make_basis(Vec3d n, Vec3d& tangent, Vec3d& bitangent) {
  const double sign = std::copysign(1.0, n.z);
  const double a = -1.0 / (sign + n.z);
  const double b = n.x * n.y * a;
  tangent = {1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x};
  bitangent = {b, sign + n.y * n.y * a, -n.y};
}

}  // namespace accel
