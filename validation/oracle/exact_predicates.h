// Where the line of a ray meets a triangle, without rounding.
//
// A float is an integer times 2^-149, so every quantity of a ray-triangle test is an integer (or a quotient of two) and has one
// true value. With a, b, c the vertices relative to the origin and d the direction, the scalar triple products
//
//   u = d . (c x b),   v = d . (a x c),   w = d . (b x a),   det = u + v + w,   num = a . (c x b)
//
// say all: the line meets the closed triangle iff det != 0 and no two of u, v, w have different signs; the point is
// (u a + v b + w c) / det, at t = num / det. det is -d . n for the normal n = (b - a) x (c - a), so that lines in the plane of
// the triangle and triangles without an area meet nothing.
//
// Two stages. filter_crossing() evaluates in double and knows how wrong it may be. Differences of floats round once (relative
// error 2^-53), then a monomial passes two differences, three products' and subtractions' roundings and two of the sum: at most
// gamma(7) times the permanent, the sum of the monomials' magnitudes. The permanent is itself computed with such an error; 16 *
// 2^-53 covers both. No product over- or underflows: three floats in range, or the smallest of floats, stay between 2^-447 and
// 2^190. exact_crossing() evaluates in integers when the filter cannot tell.
//
// Widths: coordinates in range (|x| < 2^61) are integers below 2^210, their differences below 2^211, triple products below
// 2^637; comparing two quotients takes products below 2^1274.
//
// Placed triangles. A map (core/affine.h) takes a float vertex to sums of products of floats: multiples of 2^-298 at best,
// below 2^61 where instances may be. So vertices are integers below 2^359, their differences below 2^360, a cross product's
// components below 2^721, num below 2^1083 and det below 2^935; t is num / det times a power of two of at most 2^336 either
// way, which makes numerator and denominator at most 2^1084 (a shift that long takes short numbers), and comparisons' products
// below 2^2168. In the filter a vertex is off by 3 * 2^-53 of the sum of the magnitudes that it was added up from, and its
// difference to the origin by 4 * 2^-53 of P, that sum and the origin's magnitude together. With P in place of the differences'
// magnitudes in the permanent, a monomial of three differences is off by gamma(3 * 4 + 5) times it: 32 * 2^-53 covers it and
// the permanent's error.
//
// ExactInt holds 2240 bits and never truncates. Most numbers are far shorter: points and directions are counted in the largest
// powers of two that will do, since time goes with length.
//
// Shewchuk 1997, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates", has the idea of the
// filter.
#pragma once

#include <boost/multiprecision/cpp_int.hpp>

#include "libaccel/core/affine.h"
#include "libaccel/core/ray.h"
#include "libaccel/geometry/triangle_mesh.h"

namespace accel::validation {

using ExactInt =
    boost::multiprecision::number<boost::multiprecision::cpp_int_backend<2240, 2240, boost::multiprecision::signed_magnitude,
                                                                         boost::multiprecision::unchecked, void>,
                                  boost::multiprecision::et_off>;

// A triangle, and the map that takes it into the world: none where it is there already.
struct PlacedTriangle {
  PlacedTriangle(const Triangle& t, const Affine* map = nullptr) : triangle(t), transform(map) {}

  Triangle triangle;
  const Affine* transform;
};

// The sum of the magnitudes that a coordinate is added up from. The rounded coordinate is off by at most 3 * 2^-53 of it.
inline double placed_magnitude(const Affine& a, Vec3 v, int axis) {
  const float(&m)[4] = a.m[axis];
  return std::abs(double{m[0]} * v.x) + std::abs(double{m[1]} * v.y) + std::abs(double{m[2]} * v.z) + std::abs(double{m[3]});
}

// num / den with den > 0; not reduced.
struct ExactRatio {
  ExactInt num, den;
};

// The sign of a - b. `b` is finite.
int compare(const ExactRatio& a, const ExactRatio& b);
int compare(const ExactRatio& a, float b);

// The nearest double but for a relative error of 2^-52. Ratios too small for a double become 0, too large infinity.
double to_double(const ExactRatio& a);

// The numbers named above: u, v, w and det in one unit, num in another, so that t = num / det * 2^t_exponent.
struct ExactCrossing {
  ExactInt u, v, w, det, num;
  int t_exponent;

  bool meets() const;                           // whether the line meets the closed triangle
  ExactRatio t() const;                         // only if det != 0
  ExactRatio weight(const ExactInt& of) const;  // of / det; only if det != 0
};

// All coordinates are in range.
ExactCrossing exact_crossing(const Ray& ray, const PlacedTriangle& triangle);

// Whether the three vertices lie on one line. All coordinates are in range.
bool has_zero_area(const Triangle& triangle);

enum class Decision : std::uint8_t { no, yes, unknown };

// What double precision can prove. When the line meets the triangle, t lies in [t_lo, t_hi].
struct FilteredCrossing {
  Decision meets = Decision::unknown;
  double t_lo = 0, t_hi = 0;
};
FilteredCrossing filter_crossing(const Ray& ray, const PlacedTriangle& triangle);

}  // namespace accel::validation
