// A ray enters the box of a kd-tree: its CellRay (trace/cell_ray.h) and its interval there, in SSE2, which every x86-64 machine
// has, with x, y and z in three lanes.
//
// The same operations in the same order as in enter_box_scalar(), hence the same bits. Results are passed as single floats, and
// not through pointers into the traverser's state: GCC would keep a state whose address is known in memory.
#pragma once

#include "libaccel/geometry/watertight_simd.h"
#include "libaccel/trace/cell_ray.h"

namespace accel {

// The ray for cells in `box`, which is not empty. [t_min, t_max] is the ray's interval before, and after it the part of it that
// lies in the box, in distances of cells: empty where the ray misses the box.
ACCEL_HD CellRay enter_box_scalar(const Ray& ray, const Aabb& box, float& t_min, float& t_max) {
  const CellRay cells = CellRay::prepare(ray, box);
  t_min = cells.entry(box, cells.begin(t_min));
  t_max = cells.exit(box, cells.end(t_max));
  return cells;
}

#if !ACCEL_SSE
ACCEL_HD CellRay enter_box(const Ray& ray, const Aabb& box, float& t_min, float& t_max) {
  return enter_box_scalar(ray, box, t_min, t_max);
}
#else
namespace detail {

ACCEL_HD __m128 y_of(__m128 v) { return _mm_shuffle_ps(v, v, _MM_SHUFFLE(1, 1, 1, 1)); }
ACCEL_HD __m128 z_of(__m128 v) { return _mm_shuffle_ps(v, v, _MM_SHUFFLE(2, 2, 2, 2)); }

// Whether CellRay::prepare() leaves the ray as it is: the origin is within reach of the box, the direction is not tiny.
ACCEL_HD bool is_plain(__m128 org, __m128 dir, __m128 lo, __m128 hi) {
  const __m128 outside = _mm_max_ps(_mm_sub_ps(lo, org), _mm_sub_ps(org, hi)), extent = _mm_sub_ps(hi, lo);
  const __m128 xy = _mm_unpacklo_ps(outside, extent), z = _mm_unpackhi_ps(outside, extent);
  const __m128 largest = _mm_max_ps(_mm_max_ps(xy, _mm_movehl_ps(xy, xy)), z);
  const bool is_far = _mm_comigt_ss(largest, _mm_mul_ss(_mm_set_ss(kPaddingReach), y_of(largest))) != 0;
  const __m128 tiny = _mm_cmplt_ps(_mm_andnot_ps(_mm_set1_ps(-0.0f), dir), _mm_set1_ps(CellRay::kTiny));
  return !is_far && (_mm_movemask_ps(tiny) & 7) != 7;
}

}  // namespace detail

ACCEL_HD CellRay enter_box(const Ray& ray, const Aabb& box, float& t_min, float& t_max) {
  const __m128 org = _mm_load_ps(&ray.org.x), dir = _mm_load_ps(&ray.dir.x), lo = _mm_loadu_ps(&box.lo.x);
  const __m128 z_and_hi = _mm_loadu_ps(&box.lo.z), hi = _mm_shuffle_ps(z_and_hi, z_and_hi, _MM_SHUFFLE(3, 3, 2, 1));
  if (!detail::is_plain(org, dir, lo, hi)) return enter_box_scalar(ray, box, t_min, t_max);

  // Zero of either sign has the inverse +inf.
  const __m128 zero = _mm_setzero_ps(), sign = _mm_set1_ps(-0.0f), backwards = _mm_cmplt_ps(dir, zero);
  const __m128 inv = _mm_andnot_ps(_mm_and_ps(_mm_cmpeq_ps(dir, zero), sign), _mm_div_ps(_mm_set1_ps(1), dir));

  // maxss and minss return their second operand when one is NaN, as max_of() and min_of() do.
  const __m128 swap = _mm_and_ps(_mm_xor_ps(lo, hi), backwards);
  const __m128 near_t = _mm_mul_ps(_mm_sub_ps(_mm_xor_ps(lo, swap), org), inv);
  const __m128 far_t = _mm_mul_ps(_mm_sub_ps(_mm_xor_ps(hi, swap), org), inv);
  const __m128 begin = _mm_max_ss(detail::y_of(near_t), _mm_max_ss(near_t, _mm_set_ss(t_min)));
  const __m128 end = _mm_min_ss(detail::y_of(far_t), _mm_min_ss(far_t, _mm_set_ss(t_max)));
  t_min = _mm_cvtss_f32(_mm_max_ss(detail::z_of(near_t), begin));
  t_max = _mm_cvtss_f32(_mm_min_ss(detail::z_of(far_t), end));
  return {{ray.org.x, ray.org.y, ray.org.z},
          {_mm_cvtss_f32(inv), _mm_cvtss_f32(detail::y_of(inv)), _mm_cvtss_f32(detail::z_of(inv))},
          (static_cast<std::uint32_t>(_mm_movemask_ps(backwards)) & 7u) * 0x01010101u,
          0.0f,
          1.0f};
}
#endif

}  // namespace accel
