// Three floats: points and vectors, with component-wise arithmetic.
//
// No function here contracts a multiply and an add: every operation rounds once, so that host and device agree bit for bit.
#pragma once

#include "libaccel/core/hd.h"

namespace accel {

struct Vec3 {
  float x = 0.0f, y = 0.0f, z = 0.0f;

  // Component 0, 1 or 2 (x, y, z).
  ACCEL_HD float operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
  ACCEL_HD float& operator[](int axis) { return axis == 0 ? x : axis == 1 ? y : z; }
};

ACCEL_HD Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
ACCEL_HD Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
ACCEL_HD Vec3 operator*(Vec3 a, Vec3 b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
ACCEL_HD Vec3 operator*(Vec3 a, float s) { return {a.x * s, a.y * s, a.z * s}; }
ACCEL_HD Vec3 operator*(float s, Vec3 a) { return a * s; }
ACCEL_HD Vec3 operator-(Vec3 a) { return {-a.x, -a.y, -a.z}; }
ACCEL_HD bool operator==(Vec3 a, Vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

ACCEL_HD float dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
ACCEL_HD Vec3 cross(Vec3 a, Vec3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// The smaller (larger) of two floats; when one is NaN the second argument is returned, as minss and maxss do.
ACCEL_HD float min_of(float a, float b) { return a < b ? a : b; }
ACCEL_HD float max_of(float a, float b) { return a > b ? a : b; }

ACCEL_HD Vec3 min_of(Vec3 a, Vec3 b) { return {min_of(a.x, b.x), min_of(a.y, b.y), min_of(a.z, b.z)}; }
ACCEL_HD Vec3 max_of(Vec3 a, Vec3 b) { return {max_of(a.x, b.x), max_of(a.y, b.y), max_of(a.z, b.z)}; }

// The axis of the component with the largest magnitude; the lowest axis wins ties.
ACCEL_HD int largest_axis(Vec3 v) {
  const float x = v.x < 0 ? -v.x : v.x, y = v.y < 0 ? -v.y : v.y, z = v.z < 0 ? -v.z : v.z;
  return x >= y && x >= z ? 0 : y >= z ? 1 : 2;
}

}  // namespace accel
