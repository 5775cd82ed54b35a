#include "validation/oracle/exact_predicates.h"

#include <array>
#include <cmath>
#include <limits>

namespace accel::validation {
namespace {

// Errors of a triple product relative to its permanent; derived in the header.
constexpr double kFilterError = 16.0 * 0x1p-53;
constexpr double kPlacedFilterError = 32.0 * 0x1p-53;

using ExactVector = std::array<ExactInt, 3>;

constexpr int kLeastExponent = -149;  // of floats: all are multiples of 2^-149

// The largest e for which all components are multiples of 2^e without looking at trailing zeros; `e` if that is less.
int common_exponent(Vec3 v, int e) {
  for (const float f : {v.x, v.y, v.z}) {
    if (f != 0) e = std::min(e, std::max(std::ilogb(f) - 23, kLeastExponent));
  }
  return e;
}

// f / 2^exponent, an integer.
ExactInt scaled(float f, int exponent) {
  if (f == 0) return 0;
  const int own = std::max(std::ilogb(f) - 23, kLeastExponent);
  return ExactInt(static_cast<std::int64_t>(std::ldexp(f, -own))) << (own - exponent);
}

ExactVector scaled(Vec3 v, int exponent) { return {scaled(v.x, exponent), scaled(v.y, exponent), scaled(v.z, exponent)}; }

ExactVector operator-(const ExactVector& a, const ExactVector& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

ExactVector cross(const ExactVector& a, const ExactVector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

ExactInt dot(const ExactVector& a, const ExactVector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// |x| as a fraction of at least 2^63, rounded down, times a power of two.
struct Scientific {
  long double fraction;
  int exponent;
};

Scientific scientific(const ExactInt& x) {
  const ExactInt magnitude = abs(x);
  const int shift = static_cast<int>(msb(magnitude)) - 63;
  const ExactInt top = shift >= 0 ? ExactInt(magnitude >> shift) : ExactInt(magnitude << -shift);
  return {static_cast<long double>(top.convert_to<std::uint64_t>()), shift};
}

struct DoubleVector {
  double x, y, z;
};

DoubleVector magnitude(const DoubleVector& v) { return {std::abs(v.x), std::abs(v.y), std::abs(v.z)}; }

DoubleVector difference(Vec3 a, Vec3 b) {
  return {double{a.x} - double{b.x}, double{a.y} - double{b.y}, double{a.z} - double{b.z}};
}

// A difference of points, and the magnitudes that its errors are relative to.
struct Offset {
  DoubleVector value, magnitude;

  Offset(const DoubleVector& v) : value(v), magnitude(accel::validation::magnitude(v)) {}
  Offset(Vec3 vertex, const Affine* transform, Vec3 org) : Offset(difference(vertex, org)) {
    if (transform == nullptr) return;
    const Vec3d p = transform_point(*transform, Vec3d(vertex));
    value = {p.x - org.x, p.y - org.y, p.z - org.z};
    magnitude = {placed_magnitude(*transform, vertex, 0) + std::abs(org.x),
                 placed_magnitude(*transform, vertex, 1) + std::abs(org.y),
                 placed_magnitude(*transform, vertex, 2) + std::abs(org.z)};
  }
};

// A number and how wrong it may be.
struct Bounded {
  double value, error;
};

// A cross product, and the sums of its monomials' magnitudes.
struct BoundedCross {
  DoubleVector value, permanent;

  BoundedCross(const Offset& p, const Offset& q) {
    const DoubleVector &a = p.value, &b = q.value, &m = p.magnitude, &n = q.magnitude;
    value = {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
    permanent = {m.y * n.z + m.z * n.y, m.z * n.x + m.x * n.z, m.x * n.y + m.y * n.x};
  }
  Bounded dot(const Offset& d, double relative_error) const {
    const DoubleVector &v = d.value, &m = d.magnitude;
    return {v.x * value.x + v.y * value.y + v.z * value.z,
            relative_error * (m.x * permanent.x + m.y * permanent.y + m.z * permanent.z)};
  }
};

// Takes vertices, multiples of 2^vertex, into the world, where they are multiples of 2^world.
struct PlacedUnits {
  PlacedUnits(const Affine* map, int vertex_unit) : transform(map), vertex(vertex_unit), world(vertex_unit) {
    if (transform == nullptr) return;
    linear = std::numeric_limits<float>::max_exponent;
    for (const auto& row : transform->m) linear = common_exponent({row[0], row[1], row[2]}, linear);
    world = common_exponent(transform->translation(), vertex + linear);
  }

  // The vertex in the world as a multiple of 2^unit, where unit <= world.
  ExactVector place(Vec3 v, int unit) const {
    if (transform == nullptr) return scaled(v, unit);
    const ExactVector local = scaled(v, vertex);
    ExactVector result = scaled(transform->translation(), unit);
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) result[a] += (scaled(transform->m[a][b], linear) * local[b]) << (vertex + linear - unit);
    return result;
  }

  const Affine* transform;
  int vertex, linear = 0, world;
};

}  // namespace

int compare(const ExactRatio& a, const ExactRatio& b) { return (a.num * b.den).compare(b.num * a.den); }
int compare(const ExactRatio& a, float b) { return (a.num << -kLeastExponent).compare(scaled(b, kLeastExponent) * a.den); }

double to_double(const ExactRatio& a) {
  if (a.num == 0) return 0.0;
  const Scientific num = scientific(a.num), den = scientific(a.den);
  const long double magnitude = std::ldexp(num.fraction / den.fraction, num.exponent - den.exponent);
  return static_cast<double>(a.num < 0 ? -magnitude : magnitude);
}

bool ExactCrossing::meets() const {
  const int su = u.sign(), sv = v.sign(), sw = w.sign();
  const bool mixed = (su < 0 || sv < 0 || sw < 0) && (su > 0 || sv > 0 || sw > 0);
  return !mixed && det != 0;
}

ExactRatio ExactCrossing::t() const {
  ExactRatio t = weight(num);
  (t_exponent >= 0 ? t.num : t.den) <<= std::abs(t_exponent);
  return t;
}

ExactRatio ExactCrossing::weight(const ExactInt& of) const {
  return det < 0 ? ExactRatio{ExactInt(-of), ExactInt(-det)} : ExactRatio{of, det};
}

ExactCrossing exact_crossing(const Ray& ray, const PlacedTriangle& placed) {
  constexpr int kLarge = std::numeric_limits<float>::max_exponent;
  const Triangle& triangle = placed.triangle;
  int unit = kLarge;
  for (const Vec3 v : {triangle.v0, triangle.v1, triangle.v2}) unit = common_exponent(v, unit);
  const PlacedUnits units(placed.transform, unit);
  unit = common_exponent(ray.org, units.world);
  const int dir_unit = common_exponent(ray.dir, kLarge);

  const ExactVector org = scaled(ray.org, unit), dir = scaled(ray.dir, dir_unit);
  const ExactVector a = units.place(triangle.v0, unit) - org, b = units.place(triangle.v1, unit) - org;
  const ExactVector c = units.place(triangle.v2, unit) - org;
  const ExactVector cb = cross(c, b);
  ExactCrossing result{dot(dir, cb), dot(dir, cross(a, c)), dot(dir, cross(b, a)), 0, dot(a, cb), unit - dir_unit};
  result.det = result.u + result.v + result.w;
  return result;
}

bool has_zero_area(const Triangle& triangle) {
  const DoubleVector e1 = difference(triangle.v1, triangle.v0), e2 = difference(triangle.v2, triangle.v0);
  const BoundedCross n(e1, e2);
  const auto differs = [](double value, double permanent) { return std::abs(value) > kFilterError * permanent; };
  if (differs(n.value.x, n.permanent.x) || differs(n.value.y, n.permanent.y) || differs(n.value.z, n.permanent.z)) return false;
  const ExactVector v0 = scaled(triangle.v0, kLeastExponent);
  const ExactVector exact = cross(scaled(triangle.v1, kLeastExponent) - v0, scaled(triangle.v2, kLeastExponent) - v0);
  return exact[0] == 0 && exact[1] == 0 && exact[2] == 0;
}

FilteredCrossing filter_crossing(const Ray& ray, const PlacedTriangle& placed) {
  const Triangle& triangle = placed.triangle;
  const double relative_error = placed.transform == nullptr ? kFilterError : kPlacedFilterError;
  const Offset dir(DoubleVector{ray.dir.x, ray.dir.y, ray.dir.z});
  const Offset a(triangle.v0, placed.transform, ray.org), b(triangle.v1, placed.transform, ray.org);
  const Offset c(triangle.v2, placed.transform, ray.org);
  const BoundedCross cb(c, b);
  const Bounded u = cb.dot(dir, relative_error), v = BoundedCross(a, c).dot(dir, relative_error);
  const Bounded w = BoundedCross(b, a).dot(dir, relative_error);

  // Two proven signs that differ: no. Three that agree: yes. Zeros and near zeros are for exact arithmetic.
  const int positive = (u.value > u.error) + (v.value > v.error) + (w.value > w.error);
  const int negative = (u.value < -u.error) + (v.value < -v.error) + (w.value < -w.error);
  if (positive > 0 && negative > 0) return {Decision::no};
  if (positive < 3 && negative < 3) return {Decision::unknown};

  // With |num - n| <= e and |det - m| <= f: |num / det - n / m| <= (e + |n / m| f) / (|m| - f), and a few roundings.
  const Bounded num = cb.dot(a, relative_error);
  const double det = u.value + v.value + w.value;
  const double det_error = (u.error + v.error + w.error) * (1 + 0x1p-40) + 0x1p-51 * std::abs(det);
  if (!(std::abs(det) > det_error))
    return {Decision::yes, -std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  const double t = num.value / det;
  const double radius =
      (num.error + std::abs(t) * det_error) / (std::abs(det) - det_error) * (1 + 0x1p-40) + 0x1p-51 * std::abs(t);
  return {Decision::yes, t - radius, t + radius};
}

}  // namespace accel::validation
