// How far single-precision arithmetic may move a ray-triangle test: derived once, the yardstick for every engine.
//
// The test is the watertight one (libaccel/geometry/watertight.h; Woop, Benthin and Wald 2013). Below, u = 2^-24, a hat marks
// what is computed, its absence the exact number, (X, Y, Z) = v - o with the axes permuted so that d_z is the largest
// component, and S_x = d_x / d_z, so |S| <= 1.
//
// Vertices. Z^ = Z (1 + e1). S_x^ = S_x (1 + e2). x^ = ((X (1 + e3)) - S_x^ Z^ (1 + e4)) (1 + e5), all |e| <= u. Hence
//
//   |x^ - x| <= u |X| + 3 u |S_x Z| + u |x| + O(u^2).
//
// An edge function U = C_x B_y - C_y B_x rounds its two products and their difference: C_x^ B_y^ (1 + e6) - C_y^ B_x^ (1 + e7),
// all times (1 + e8). Rounding is monotone, so the sign is that of the exact expression in C^, B^, or zero. In value it is the
// exact expression for vertices whose coordinates move by another 2 u each. Altogether, an edge function is what exact
// arithmetic gives for vertices that are moved in x by no more than
//
//   eps_x = u (|X| + 3 |S_x Z| + 3 |x|) (1 + 2^-18) + 2^-149 (1 + |Z|),
//
// and in y likewise. The factor covers the terms in u^2 (below 2^-21 of the rest) and the evaluation of these formulae in
// double (below 2^-26 of it); the last term covers underflow, which is gradual: a product or quotient that underflows is off by
// 2^-150. So
//
//   |U^ - U| <= E_U = eps_Cx |B_y| + eps_By |C_x| + eps_Cy |B_x| + eps_Bx |C_y| + eps_Cx eps_By + eps_Cy eps_Bx + 2^-149.
//
// Edges. The moved edge can touch the ray only if |U| <= E_U and the box of its two vertices, each widened by its eps, contains
// the origin: then the ray is *near* the edge. The second condition bounds the place along the edge, and its ends. A triangle
// is *possible* for the ray, that is some rounding may accept it, only if no two edge functions have opposite signs beyond
// doubt (|U| > E_U), and its widened box contains the origin. The triangle is surely hit if it is possible and near no edge.
//
// Distance. t^ = ((b0 z0 + b1 z1) + b2 z2) / d_z with b_i = U_i^ / det^. The U_i^ of an accepted triangle have one sign, so
// l_i = U_i^ / sum U^ are weights of a convex combination, and rounding (Z 1, det 2, quotient 1, product 1, sums 2, division 1)
// gives
//
//   |t^ d_z - sum l_i z_i| <= gamma(8) sum l_i |z_i|.
//
// First, that puts t^ between the nearest and the farthest vertex. Second, with D = sum U_i, E = sum E_i and z = sum U_i z_i /
// D the depth of the plane: sum l_i z_i - z = sum l_i (z_i - z) = sum (U_i^ - U_i) (z_i - z) / sum U^, because sum U_i (z_i -
// z) = 0. So
//
//   |sum l_i z_i - z| <= sum E_i |z_i - z| / (|D| - E)   if |D| > E, and is bounded by the vertices only otherwise.
//
// [t_lo, t_hi] is the intersection of the two, widened by the rounding term. z may be evaluated in double: its error is the
// same expression with the errors of double in place of E_i, which the factor 1 + 2^-18 in E_i covers.
//
// Instances. A traverser takes the ray into the instance's space and tests the mesh there, so this is done there too: with the
// exact ray of that space, o and d, where the test has the rounded o^ and d^. With L the inverse map, T its translation and the
// bounds of core/affine.h (and one u more, for the rounding of the inverse and of the formulae in double, and for underflow),
//
//   |o^ - o|_i <= a_i = gamma(6) sum_j |L_ij| |o_j - T_j| (world) + 2^-148 (1 + sum_j |o_j - T_j|),
//   |d^ - d|_i <= b_i = gamma(5) sum_j |L_ij| |d_j| + 2^-148 (1 + sum_j |d_j|),
//
// and none where the map is the identity. Let e(t) = (o^ - o) + t (d^ - d). The rounded ray comes to the depth Z of a vertex at
// t^ = t + e_z(t^) / d_z (t the exact ray's), and there it is e_x(t^) - S_x e_z(t^) beside it. So the test sees the vertex
// moved by that, besides its own errors: with r = b_z / |d_z| < 1/2 and t_max = (|Z / d_z| + a_z / |d_z|) / (1 - r) >= |t^|,
//
//   in depth, counted as t d_z,  by no more than  eps_z = a_z + t_max b_z,
//   in x                         by no more than  a_x + t_max b_x + |S_x| eps_z,
//
// which is added to eps_x, whose formula then takes |X|, |S_x Z| and |x| larger by a_x or by that. The depths of the vertices
// in the bound of t are off by the largest eps_z. All triangles of an instance are tested with one rounded ray, so that
// vertices that they share move together, as the argument of judge.h wants; those of different instances do not. The axes are
// those that the rounded direction chooses. r >= 1/2 excuses everything: nothing bounds the rounded ray there.
//
// Other engines compute otherwise. They are measured by this bound all the same, so that one number means one thing.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "libaccel/core/affine.h"
#include "libaccel/core/float_bounds.h"
#include "libaccel/core/ray.h"
#include "libaccel/geometry/triangle_mesh.h"

namespace accel::validation {

// A vertex moves by no more than eps_x in x and eps_y in y, |X|, |S_x Z| <= M and |x| <= 2 M for its largest distance M from
// the origin along an axis: by 10 u M, and its depth by 8 u M, which along the ray is as much again in x and y. 64 u M is
// ample.
inline constexpr double kNearPadding = 64 * 0x1p-24;

// A vertex in the frame of the ray: the ray is the z axis. In double; errors and all are covered by the bounds.
struct FrameVertex {
  double x, y, z;
  double eps_x, eps_y;  // how far single precision may move it
  double eps_z = 0;     // and the depth at which a ray meets it
};

// The frame of the watertight test. The ray is traceable.
class RayFrame {
 public:
  explicit RayFrame(const Ray& ray)
      : kz_(largest_axis(ray.dir)),
        kx_(kz_ == 2 ? 0 : kz_ + 1),
        ky_(kx_ == 2 ? 0 : kx_ + 1),
        org_x_(ray.org[kx_]),
        org_y_(ray.org[ky_]),
        org_z_(ray.org[kz_]),
        dir_z_(ray.dir[kz_]),
        shear_x_(ray.dir[kx_] / dir_z_),
        shear_y_(ray.dir[ky_] / dir_z_) {}

  // The frame in the space of an instance, whose map invert_linear() accepts.
  RayFrame(const Ray& ray, const Affine& transform) : RayFrame(inverse(transform)->ray(ray)) {
    const double org[3] = {ray.org.x, ray.org.y, ray.org.z}, dir[3] = {ray.dir.x, ray.dir.y, ray.dir.z};
    // A ray that leaves the range of the library in that space passes the instance by.
    is_traceable_ = accel::is_traceable(inverse(transform)->ray(ray));
    if (transform == Affine{}) return;
    const LinearInverse linear = *invert_linear(transform);
    double local_org[3], local_dir[3], org_error[3], dir_error[3];
    for (int i = 0; i < 3; ++i) {
      double o = 0, d = 0, o_sum = 0, d_sum = 0, o_size = 1, d_size = 1;
      for (int j = 0; j < 3; ++j) {
        const double from = org[j] - transform.m[j][3], m = linear.m[i][j];
        o += m * from, d += m * dir[j];
        o_sum += std::abs(m * from), d_sum += std::abs(m * dir[j]);
        o_size += std::abs(from), d_size += std::abs(dir[j]);
      }
      local_org[i] = o, local_dir[i] = d;
      org_error[i] = gamma(kInverseRoundings + 1) * o_sum + 0x1p-148 * o_size;
      dir_error[i] = gamma(kInverseRoundings) * d_sum + 0x1p-148 * d_size;
    }
    org_x_ = local_org[kx_], org_y_ = local_org[ky_], org_z_ = local_org[kz_];
    dir_z_ = local_dir[kz_], shear_x_ = local_dir[kx_] / dir_z_, shear_y_ = local_dir[ky_] / dir_z_;
    a_x_ = org_error[kx_], a_y_ = org_error[ky_], a_z_ = org_error[kz_];
    b_x_ = dir_error[kx_], b_y_ = dir_error[ky_], b_z_ = dir_error[kz_];
    is_bounded_ = b_z_ < 0.5 * std::abs(dir_z_);
  }

  // Where the ray is bounded.
  FrameVertex operator()(Vec3 v) const {
    const double dx = v[kx_] - org_x_, dy = v[ky_] - org_y_, dz = v[kz_] - org_z_;
    const double x = dx - shear_x_ * dz, y = dy - shear_y_ * dz;
    if (a_z_ == 0) return {x, y, dz, epsilon(dx, shear_x_ * dz, x, dz), epsilon(dy, shear_y_ * dz, y, dz)};

    // In an instance's space: what the ray's rounding adds.
    const double r = b_z_ / std::abs(dir_z_);
    const double t_max = (std::abs(dz) + a_z_) / (std::abs(dir_z_) * (1 - r));
    const double eps_z = a_z_ + t_max * b_z_;
    const auto moved = [&](double d, double shear, double sum, double a, double b) {
      const double beside = a + t_max * b + std::abs(shear) * eps_z;
      return beside + epsilon(std::abs(d) + a, std::abs(shear * dz) + a + beside, std::abs(sum) + beside, std::abs(dz) + a_z_);
    };
    return {x, y, dz, moved(dx, shear_x_, x, a_x_, b_x_), moved(dy, shear_y_, y, a_y_, b_y_), eps_z};
  }

  double dir_z() const { return dir_z_; }
  bool is_traceable() const { return is_traceable_; }
  bool is_bounded() const { return is_bounded_; }

 private:
  static double epsilon(double difference, double sheared, double sum, double z) {
    constexpr double kUnit = 0x1p-24 * (1 + 0x1p-18);
    return kUnit * (std::abs(difference) + 3 * std::abs(sheared) + 3 * std::abs(sum)) + 0x1p-149 * (1 + std::abs(z));
  }

  int kz_, kx_, ky_;
  double org_x_, org_y_, org_z_, dir_z_, shear_x_, shear_y_;
  double a_x_ = 0, a_y_ = 0, a_z_ = 0, b_x_ = 0, b_y_ = 0, b_z_ = 0;  // errors of the ray in an instance's space
  bool is_traceable_ = true, is_bounded_ = true;
};

// The edge function of an edge, and the bound of its error.
struct BoundedEdge {
  double value, error;
  bool near;  // whether the moved edge may touch the ray

  BoundedEdge(const FrameVertex& b, const FrameVertex& c)
      : value(c.x * b.y - c.y * b.x),
        error(c.eps_x * std::abs(b.y) + b.eps_y * std::abs(c.x) + c.eps_y * std::abs(b.x) + b.eps_x * std::abs(c.y) +
              c.eps_x * b.eps_y + c.eps_y * b.eps_x + 0x1p-149),
        near(std::abs(value) <= error && straddles(b.x, b.eps_x, c.x, c.eps_x) && straddles(b.y, b.eps_y, c.y, c.eps_y)) {}

  bool surely_positive() const { return value > error; }
  bool surely_negative() const { return value < -error; }

 private:
  static bool straddles(double p, double eps_p, double q, double eps_q) {
    return std::min(p - eps_p, q - eps_q) <= 0 && std::max(p + eps_p, q + eps_q) >= 0;
  }
};

// What single precision may make of one triangle and the line of one ray.
struct TriangleBounds {
  std::array<FrameVertex, 3> vertex;
  std::array<bool, 3> edge_near{};  // edge i is opposite vertex i
  bool possible = false;            // whether the triangle may be accepted; then at a t in [t_lo, t_hi]
  double t_lo = std::numeric_limits<double>::infinity();
  double t_hi = -std::numeric_limits<double>::infinity();

  TriangleBounds(const RayFrame& frame, const Triangle& triangle)
      : vertex{frame(triangle.v0), frame(triangle.v1), frame(triangle.v2)} {
    if (!frame.is_bounded()) {
      possible = frame.is_traceable(), edge_near = {true, true, true};
      std::swap(t_lo, t_hi);
      return;
    }
    const std::array<BoundedEdge, 3> edges{BoundedEdge{vertex[1], vertex[2]}, BoundedEdge{vertex[2], vertex[0]},
                                           BoundedEdge{vertex[0], vertex[1]}};
    bool positive = false, negative = false;
    for (int i = 0; i < 3; ++i) {
      edge_near[i] = edges[i].near;
      positive |= edges[i].surely_positive(), negative |= edges[i].surely_negative();
    }
    if ((positive && negative) || !box_contains_ray() || !frame.is_traceable()) return;
    bound_t(edges, frame.dir_z());
    possible = t_lo <= t_hi;
  }

  bool allows(double t) const { return possible && t >= t_lo && t <= t_hi; }
  bool near_any_edge() const { return edge_near[0] || edge_near[1] || edge_near[2]; }

 private:
  bool box_contains_ray() const {
    const auto [a, b, c] = vertex;
    return std::min({a.x - a.eps_x, b.x - b.eps_x, c.x - c.eps_x}) <= 0 &&
           std::max({a.x + a.eps_x, b.x + b.eps_x, c.x + c.eps_x}) >= 0 &&
           std::min({a.y - a.eps_y, b.y - b.eps_y, c.y - c.eps_y}) <= 0 &&
           std::max({a.y + a.eps_y, b.y + b.eps_y, c.y + c.eps_y}) >= 0;
  }

  void bound_t(const std::array<BoundedEdge, 3>& edges, double dir_z) {
    double lo = std::min({vertex[0].z, vertex[1].z, vertex[2].z});
    double hi = std::max({vertex[0].z, vertex[1].z, vertex[2].z});
    const double moved = std::max({vertex[0].eps_z, vertex[1].eps_z, vertex[2].eps_z});
    double mean_magnitude = std::max(std::abs(lo), std::abs(hi)) + moved;  // of sum l_i |z_i|

    // The depth of the plane, where the triangle is not too edge-on to have one.
    const double det = edges[0].value + edges[1].value + edges[2].value;
    const double det_error = edges[0].error + edges[1].error + edges[2].error;
    const double det_least = std::abs(det) - det_error;
    if (det_least > 0) {
      double z = 0, spread = 0, magnitude = 0;
      for (int i = 0; i < 3; ++i) z += edges[i].value * vertex[i].z;
      z /= det;
      for (int i = 0; i < 3; ++i) {
        spread += edges[i].error * std::abs(vertex[i].z - z) / det_least;
        magnitude += (std::abs(edges[i].value) + edges[i].error) / det_least * std::abs(vertex[i].z);
      }
      lo = std::max(lo, z - spread), hi = std::min(hi, z + spread);
      mean_magnitude = std::min(mean_magnitude, magnitude + moved);
    }

    // Rounding: gamma(8); underflow of three weights, three products and a quotient.
    const double rounding = 8 * 0x1p-24 * (1 + 0x1p-18) * mean_magnitude + 3 * 0x1p-149 * (1 + mean_magnitude);
    lo -= rounding + moved, hi += rounding + moved;
    t_lo = (dir_z > 0 ? lo : hi) / dir_z - 0x1p-149;
    t_hi = (dir_z > 0 ? hi : lo) / dir_z + 0x1p-149;
  }
};

}  // namespace accel::validation
