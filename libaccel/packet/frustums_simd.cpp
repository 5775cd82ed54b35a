#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "libaccel/packet/frustums_simd.cpp"
#include <hwy/foreach_target.h>
// Above all other headers.
#include <hwy/highway.h>

#include "libaccel/packet/frustums_simd.h"
#include "libaccel/packet/packet_simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace accel {
namespace HWY_NAMESPACE {
namespace {

// What make_frustum() (packet/frustum.h) finds.
HWY_INLINE Frustum frustum_of(const Packet& p, std::uint32_t face, const Aabb& bounds) {
  const auto width = static_cast<std::uint32_t>(hn::Lanes(kFloats));
  Frustum frustum{.face = face};
  const int axis = frustum.axis();
  Floats nearest = set(kInfinity), farthest = set(-kInfinity), origins = hn::Zero(kFloats);
  std::size_t negative[3] = {};
  for (std::uint32_t i = 0; i < p.lanes; i += width) {
    const Floats org = load(p.org[axis] + i), dir = load(p.dir[axis] + i);
    const Floats first = hn::Add(org, hn::Mul(dir, load(p.t_min + i))), last = hn::Add(org, hn::Mul(dir, load(p.t + i)));
    // Lanes without a ray are beyond all others.
    const auto is_ray = hn::Lt(load(p.t_min + i), set(kInfinity));
    nearest = hn::IfThenElse(is_ray, least(least(first, last), nearest), nearest);
    farthest = hn::IfThenElse(is_ray, most(most(first, last), farthest), farthest);
    for (int a = 0; a < 3; ++a) {
      origins = most(hn::Abs(load(p.org[a] + i)), origins);
      negative[a] += hn::CountTrue(kFloats, hn::And(is_ray, hn::Lt(load(p.dir[a] + i), hn::Zero(kFloats))));
    }
  }
  for (int a = 0; a < 3; ++a) frustum.signs |= (2 * negative[a] > p.size ? 1u : 0u) << a;
  const float begin = max_of(least_lane(nearest), bounds.lo[axis]), end = min_of(most_lane(farthest), bounds.hi[axis]);

  detail::Range first[2], last[2];
  for (int s = 0; s < 2; ++s) {
    const int a = frustum.side_axis(s);
    Floats least_first = set(kInfinity), most_first = set(-kInfinity), least_last = least_first, most_last = most_first;
    for (std::uint32_t i = 0; i < p.lanes; i += width) {
      const Floats x0 = at_plane(p, i, axis, a, begin), x1 = at_plane(p, i, axis, a, end);
      least_first = least(x0, least_first), most_first = most(x0, most_first);
      least_last = least(x1, least_last), most_last = most(x1, most_last);
    }
    first[s] = {least_lane(least_first), most_lane(most_first)}, last[s] = {least_lane(least_last), most_lane(most_last)};
  }
  frustum.set_sides(begin, end, first, last, most_lane(origins));
  return frustum;
}

HWY_INLINE Mask within(Floats v, float limit) { return hn::Le(hn::Abs(v), set(limit)); }

// face_of() (packet/frustum.h).
HWY_INLINE Words faces_of(const RayLanes& r) {
  const Floats zero = hn::Zero(kFloats);
  Mask has_face = hn::And(hn::Le(r.t_min, r.t_max), hn::Ge(r.t_max, zero));
  Mask runs = hn::Lt(zero, zero);
  Floats size[3];
  for (int a = 0; a < 3; ++a) {
    size[a] = hn::Abs(r.dir[a]);
    const Mask is_zero = hn::Eq(r.dir[a], zero);
    has_face = hn::And(has_face, hn::And(within(r.org[a], kMaxCoordinate), within(r.dir[a], kMaxCoordinate)));
    has_face = hn::And(has_face, hn::Or(is_zero, hn::Ge(size[a], set(std::numeric_limits<float>::min()))));
    runs = hn::Or(runs, hn::Not(is_zero));
  }
  const Mask is_x = hn::And(hn::Ge(size[0], size[1]), hn::Ge(size[0], size[2])), is_y = hn::Ge(size[1], size[2]);
  const Floats along = hn::IfThenElse(is_x, r.dir[0], hn::IfThenElse(is_y, r.dir[1], r.dir[2]));
  const Words axis = hn::IfThenElse(hn::RebindMask(kWords, is_x), hn::Set(kWords, 0),
                                    hn::IfThenElse(hn::RebindMask(kWords, is_y), hn::Set(kWords, 2), hn::Set(kWords, 4)));
  const Words face = hn::Add(axis, hn::IfThenElseZero(hn::RebindMask(kWords, hn::Lt(along, zero)), hn::Set(kWords, 1)));
  return hn::IfThenElse(hn::RebindMask(kWords, hn::And(has_face, runs)), face, hn::Set(kWords, kNoFace));
}

void find_faces(const Ray* rays, std::size_t count, std::uint8_t* faces) {
  const std::size_t width = hn::Lanes(kFloats), whole = count - count % width;
  const hn::Rebind<std::int32_t, decltype(kFloats)> ints;
  const hn::Rebind<std::uint8_t, decltype(kFloats)> bytes;
  for (std::size_t i = 0; i < whole; i += width)
    hn::StoreU(hn::DemoteTo(bytes, hn::BitCast(ints, faces_of(load_lanes(rays + i)))), bytes, faces + i);
  for (std::size_t i = whole; i < count; ++i) faces[i] = static_cast<std::uint8_t>(face_of(rays[i]));
}

void make(const LocalizedBatch& batch, const std::uint8_t* faces, const Aabb& bounds, Frustum* frustums) {
  Packet packet;
  for (std::size_t i = 0; i < batch.count; ++i) {
    const std::uint32_t first = batch.packets[batch.active[i]], end = batch.packets[batch.active[i] + 1];
    load_rays(batch.rays, batch.ids + first, end - first, packet);
    frustums[i] = frustum_of(packet, faces[first], bounds);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace accel
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace accel {
HWY_EXPORT(find_faces);
HWY_EXPORT(make);

void find_faces_simd(const Ray* rays, std::size_t count, std::uint8_t* faces) {
  HWY_DYNAMIC_DISPATCH(find_faces)(rays, count, faces);
}

void make_frustums_simd(const LocalizedBatch& batch, const std::uint8_t* faces, const Aabb& bounds, Frustum* frustums) {
  HWY_DYNAMIC_DISPATCH(make)(batch, faces, bounds, frustums);
}
}  // namespace accel
#endif
