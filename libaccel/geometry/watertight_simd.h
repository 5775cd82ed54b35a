// The watertight test (watertight.h) in SSE2, which every x86-64 machine has: the three vertices of a triangle in three lanes.
//
// The same operations in the same order as Watertight::intersect_scalar, hence the same bits.
#pragma once

#include "libaccel/core/hit.h"
#include "libaccel/geometry/packed_triangle.h"

// Off under a CUDA compiler, for host code too: the states of traversers must have one layout in both of its passes.
#if defined(__SSE2__) && !defined(__CUDACC__)
#define ACCEL_SSE 1
#include <emmintrin.h>
#else
#define ACCEL_SSE 0
#endif

namespace accel {

// Of a triangle projected along a ray: edge functions, each opposite the vertex of its number, and depths of the vertices. The
// fourth element is room for a SIMD store.
struct alignas(16) WatertightProjection {
  float edge[4], z[4];
};

// The edge functions of a projected triangle over their largest magnitude: with the exact signs, because products of floats are
// exact in double and their difference is rounded there, and safe from underflow, because only their ratios count.
ACCEL_HD void refine_edge_functions(const float x[3], const float y[3], float edge[3]) {
  double exact[3], largest = 0;
  for (int i = 0; i < 3; ++i) {
    const int next = i == 2 ? 0 : i + 1, last = i == 0 ? 2 : i - 1;
    exact[i] = static_cast<double>(x[last]) * y[next] - static_cast<double>(y[last]) * x[next];
    const double size = exact[i] < 0 ? -exact[i] : exact[i];
    largest = size > largest ? size : largest;
  }
  for (int i = 0; i < 3; ++i) edge[i] = largest > 0 ? static_cast<float>(exact[i] / largest) : 0.0f;
}

// Whether no two of the three have different signs.
ACCEL_HD bool all_on_one_side(const float uvw[3]) {
  return (uvw[0] >= 0 && uvw[1] >= 0 && uvw[2] >= 0) || (uvw[0] <= 0 && uvw[1] <= 0 && uvw[2] <= 0);
}

#if ACCEL_SSE
template <class RayData>
ACCEL_HD bool project_sse(const PackedTriangle& triangle, const RayData& ray, WatertightProjection& projection) {
  // Lane 3 holds prim_id bits, which as a float may be denormal and slow to multiply: it is cleared.
  const __m128 xyz_lanes = _mm_castsi128_ps(_mm_set_epi32(0, -1, -1, -1));
  const auto load = [&](int axis) { return _mm_and_ps(_mm_load_ps(triangle.axis[axis].vertex), xyz_lanes); };

  const __m128 z = _mm_sub_ps(load(ray.kz), _mm_set1_ps(ray.org_z));
  const __m128 x = _mm_sub_ps(_mm_sub_ps(load(ray.kx), _mm_set1_ps(ray.org_x)), _mm_mul_ps(_mm_set1_ps(ray.shear_x), z));
  const __m128 y = _mm_sub_ps(_mm_sub_ps(load(ray.ky), _mm_set1_ps(ray.org_y)), _mm_mul_ps(_mm_set1_ps(ray.shear_y), z));

  // Lane i of `next` is vertex i + 1, of `last` vertex i + 2 (mod 3); the edge function of lane i is opposite vertex i.
  const auto next = [](__m128 a) { return _mm_shuffle_ps(a, a, _MM_SHUFFLE(1, 0, 2, 1)); };
  const auto last = [](__m128 a) { return _mm_shuffle_ps(a, a, _MM_SHUFFLE(0, 1, 0, 2)); };
  const __m128 edge = _mm_sub_ps(_mm_mul_ps(last(x), next(y)), _mm_mul_ps(last(y), next(x)));

  const __m128 zero = _mm_setzero_ps();
  const int not_negative = _mm_movemask_ps(_mm_cmpge_ps(edge, zero)) & 7;
  const int not_positive = _mm_movemask_ps(_mm_cmple_ps(edge, zero)) & 7;
  if (not_negative != 7 && not_positive != 7) return false;
  _mm_store_ps(projection.edge, edge), _mm_store_ps(projection.z, z);
  if ((not_negative & not_positive) == 0) return true;

  // An edge function is zero.
  alignas(16) float xs[4], ys[4];
  _mm_store_ps(xs, x), _mm_store_ps(ys, y);
  refine_edge_functions(xs, ys, projection.edge);
  return all_on_one_side(projection.edge);
}
#endif

}  // namespace accel
