#include "libaccel/geometry/mesh_facts.h"

#include <cmath>
#include <limits>

#include "libaccel/core/ray.h"
#include "libaccel/core/vec3d.h"

namespace accel {
namespace {

// A difference of two floats as a double, and whether it is exact (Knuth's two-sum).
struct Difference {
  double value;
  bool exact;
};
Difference subtract(float a, float b) {
  const double x = a, y = b, d = x - y;
  const double back = d - x;
  return {d, (x - (d - back)) - (y + back) == 0.0};
}

// Whether a b = c d exactly. A double product and its rounding error are equal exactly when the products are: magnitudes
// between 2^-298 and 2^124, which is what differences of floats in range have, neither overflow nor lose the error to
// underflow.
bool products_are_equal(double a, double b, double c, double d) {
  const double ab = a * b, cd = c * d;
  return ab == cd && std::fma(a, b, -ab) == std::fma(c, d, -cd);
}

// Whether a b - c d is not zero for any doubles near these: each of the five roundings since the floats moved a product by less
// than 2^-52 of it. Most triangles need no other proof.
bool are_clearly_different(double a, double b, double c, double d) {
  const double ab = a * b, cd = c * d;
  return std::abs(ab - cd) > 0x1p-48 * (std::abs(ab) + std::abs(cd));
}

bool clearly_has_area(const Triangle& t) {
  const Vec3d e = Vec3d(t.v1) - Vec3d(t.v0), f = Vec3d(t.v2) - Vec3d(t.v0);
  return are_clearly_different(e.x, f.y, e.y, f.x) || are_clearly_different(e.y, f.z, e.z, f.y) ||
         are_clearly_different(e.z, f.x, e.x, f.z);
}

}  // namespace

bool is_zero_area(const Triangle& t) {
  if (clearly_has_area(t)) return false;
  if (t.v0 == t.v1 || t.v1 == t.v2 || t.v2 == t.v0) return true;
  Difference e[3], f[3];
  for (int a = 0; a < 3; ++a) e[a] = subtract(t.v1[a], t.v0[a]), f[a] = subtract(t.v2[a], t.v0[a]);

  // The normal's components vanish; a component that is clearly not zero settles it without the proof.
  for (int a = 0; a < 3; ++a) {
    const int b = a == 2 ? 0 : a + 1;
    const bool exact = e[a].exact && e[b].exact && f[a].exact && f[b].exact;
    if (!exact || !products_are_equal(e[a].value, f[b].value, e[b].value, f[a].value)) return false;
  }
  return true;
}

bool is_in_range(const Triangle& t) { return in_range(t.v0) && in_range(t.v1) && in_range(t.v2); }

MeshFacts mesh_facts(const TriangleSource& triangles) {
  MeshFacts facts;
  facts.triangles = triangles.size();
  for (std::uint64_t i = 0; i < triangles.size(); ++i) {
    const Triangle triangle = triangles.triangle(static_cast<std::uint32_t>(i));
    if (!is_in_range(triangle)) {
      ++facts.out_of_range;
    } else if (is_zero_area(triangle)) {
      ++facts.zero_area;
    } else {
      facts.bounds.extend(triangle.bounds());
    }
  }
  return facts;
}

}  // namespace accel
