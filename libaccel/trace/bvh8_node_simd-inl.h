// A ray against the nodes and leaves of a Bvh8, eight boxes or four triangles in SIMD lanes: the box test of trace/bvh8_ray.h,
// with the same operations. The guard lets the header through once for each target that Highway compiles.
#if defined(ACCEL_BVH8_NODE_SIMD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ACCEL_BVH8_NODE_SIMD_INL_H
#undef ACCEL_BVH8_NODE_SIMD_INL_H
#else
#define ACCEL_BVH8_NODE_SIMD_INL_H
#endif

#include <hwy/highway.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "libaccel/structure/bvh8_coded.h"
#include "libaccel/trace/bvh8_ray.h"
#include "libaccel/trace/indexed_block_simd-inl.h"
#include "libaccel/trace/triangle_block_simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace accel {
namespace HWY_NAMESPACE {
namespace {

const hn::CappedTag<float, kBvh8Arity> kBoxes;
const hn::RebindToUnsigned<decltype(kBoxes)> kRefs;
using Boxes = decltype(hn::Zero(kBoxes));

// Where a ray postpones children: each with its entry distance, and room for a whole vector behind the last.
struct Postponed {
  NodeRef* node;
  float* t_near;
};

// Bvh8Ray::prepare() and is_traceable(), in lanes: org and t_min, dir and t_max.
struct alignas(16) Slopes {
  float inv_near[4], inv_far[4];
  std::uint32_t octant;

  // False if the ray is not traceable.
  HWY_INLINE bool prepare(const Ray& ray) {
    static_assert(offsetof(Ray, t_min) == 12 && offsetof(Ray, dir) == 16 && offsetof(Ray, t_max) == 28);
    const float *const org = &ray.org.x, *const dir = &ray.dir.x;
    const auto set = [](float v) HWY_ATTR { return hn::Set(kTriangles, v); };
    const auto largest = set(std::numeric_limits<float>::max()), most_coordinate = set(kMaxCoordinate);
    std::uint32_t in_range = 0, moves = 0, backwards = 0;
    for (std::size_t i = 0; i < 4; i += hn::Lanes(kTriangles)) {
      const auto d = hn::LoadU(kTriangles, dir + i), o = hn::LoadU(kTriangles, org + i), inv = hn::Div(set(1), d);
      const auto is_zero = hn::Eq(d, set(0));
      const auto overflowed = hn::AndNot(is_zero, hn::Gt(hn::Abs(inv), largest));
      hn::Store(hn::IfThenElse(overflowed, hn::CopySign(largest, inv), inv), kTriangles, inv_near + i);
      hn::Store(inv, kTriangles, inv_far + i);
      const auto good = hn::And(hn::Le(hn::Abs(o), most_coordinate), hn::Le(hn::Abs(d), most_coordinate));
      in_range |= bits_of(kTriangles, good) << i;
      moves |= bits_of(kTriangles, hn::Not(is_zero)) << i;
      backwards |= bits_of(kTriangles, hn::Lt(inv, set(0))) << i;
    }
    octant = backwards & 7u;
    return (in_range & 7u) == 7u && (moves & 7u) != 0 && ray.t_min <= ray.t_max && ray.t_max >= 0;
  }
};

// Planes of children, from the one at `at` on: of an axis, in the order of Node::planes.
HWY_INLINE Boxes load_planes(const Bvh8Node& node, int axis, std::size_t at) {
  return hn::Load(kBoxes, node.planes[axis][0] + at);
}
template <class Coding>
HWY_INLINE Boxes load_planes(const CodedBvh8Node<Coding>& node, int axis, std::size_t at) {
  const hn::Rebind<typename Coding::Code, decltype(kBoxes)> codes;
  const hn::RebindToSigned<decltype(kBoxes)> integers;
  const auto code = hn::PromoteTo(integers, hn::LoadU(codes, node.planes[axis][0] + at));
  Boxes value;
  if constexpr (std::is_same_v<Coding, ByteCoding>)
    value = hn::ConvertTo(kBoxes, code);
  else
    value = hn::Mul(hn::BitCast(kBoxes, hn::ShiftLeft<13>(code)), hn::Set(kBoxes, 0x1p112f));
  // The product is exact: one rounding, fused or not.
  return hn::MulAdd(value, hn::Set(kBoxes, node.scale(axis)), hn::Set(kBoxes, node.origin[axis]));
}

// The box test of a ray, as it is kept in memory: numbers are spread over the lanes when a node is tested.
template <class Slabs>
struct RayBoxes {
  float org_near[3], org_far[3];  // the origin; of fused slabs, times the reciprocals
  float inv_near[3], inv_far[3], t_min;
  std::uint8_t near_at[3];  // where near planes are in a node, in codes or floats
  std::uint8_t octant;

  RayBoxes() = default;
  HWY_INLINE RayBoxes(const Ray& ray, const Slopes& slopes) {
    for (int a = 0; a < 3; ++a) {
      const float org = (&ray.org.x)[a];
      inv_near[a] = slopes.inv_near[a];
      inv_far[a] = slopes.inv_far[a] * Slabs::kFarPlaneScale;
      org_near[a] = Slabs::kIsFused ? org * inv_near[a] : org;
      org_far[a] = Slabs::kIsFused ? org * inv_far[a] : org;
      near_at[a] = static_cast<std::uint8_t>((slopes.octant >> a & 1u) * kBvh8Arity);
    }
    t_min = first_t(ray);
    octant = static_cast<std::uint8_t>(slopes.octant);
  }

  static HWY_INLINE Boxes distance(Boxes planes, float org, float inv) {
    const auto all_org = hn::Set(kBoxes, org), all_inv = hn::Set(kBoxes, inv);
    return Slabs::kIsFused ? hn::MulSub(planes, all_inv, all_org) : hn::Mul(hn::Sub(planes, all_org), all_inv);
  }

  // Where the children from `first` on are entered, and left.
  template <class Node>
  HWY_INLINE void meet(const Node& node, std::size_t first, Boxes limit, Boxes& enter, Boxes& leave) const {
    Boxes nearer[3], farther[3];
    for (int a = 0; a < 3; ++a) {
      const std::size_t near_planes = near_at[a];
      nearer[a] = distance(load_planes(node, a, first + near_planes), org_near[a], inv_near[a]);
      farther[a] = distance(load_planes(node, a, first + (near_planes ^ kBvh8Arity)), org_far[a], inv_far[a]);
    }
    enter = most(most(nearer[1], nearer[2]), most(nearer[0], hn::Set(kBoxes, t_min)));
    leave = least(least(farther[1], farther[2]), least(farther[0], limit));
    if constexpr (!Node::kAbsentAreFar || Slabs::kIsFused) {
      // NaN, which is not before anything: where the ray leaves may be at infinity.
      const auto absent = hn::Eq(hn::Load(kRefs, node.child + first), hn::Set(kRefs, kNoNode));
      enter = hn::IfThenElse(hn::RebindMask(kBoxes, absent), hn::NaN(kBoxes), enter);
    }
  }
};

// Postpones the children that the ray enters, the nearest last. Returns the bits of their places in the node's order.
template <Query kQuery, class Node, class Slabs>
HWY_INLINE std::uint32_t push_children(const Node& node, const RayBoxes<Slabs>& ray, float limit, Postponed stack,
                                       std::size_t& size) {
#if HWY_TARGET <= HWY_AVX2 && HWY_ARCH_X86
  Boxes enter, leave;
  ray.meet(node, 0, hn::Set(kBoxes, limit), enter, leave);
  auto refs = hn::Load(kRefs, node.child);
  if constexpr (kQuery == Query::closest) {
    const auto order = hn::And(hn::ShiftRightSame(hn::Load(kRefs, node.order), 3 * ray.octant), hn::Set(kRefs, 7u));
    const auto in_order = hn::IndicesFromVec(kBoxes, order);
    enter = hn::TableLookupLanes(enter, in_order), leave = hn::TableLookupLanes(leave, in_order);
    refs = hn::TableLookupLanes(refs, hn::IndicesFromVec(kRefs, order));
  }
  const auto entered = hn::Le(enter, leave);
  if constexpr (kQuery == Query::closest) hn::StoreU(hn::Compress(enter, entered), kBoxes, stack.t_near + size);
  hn::StoreU(hn::Compress(refs, hn::RebindMask(kRefs, entered)), kRefs, stack.node + size);
  const std::uint32_t places = bits_of(kBoxes, entered);
  size += static_cast<std::size_t>(std::popcount(places));
  return places;
#else
  alignas(64) float t_near[kBvh8Arity];
  std::uint32_t entered = 0, places = 0;
  for (std::size_t first = 0; first < kBvh8Arity; first += hn::Lanes(kBoxes)) {
    Boxes enter, leave;
    ray.meet(node, first, hn::Set(kBoxes, limit), enter, leave);
    hn::Store(enter, kBoxes, t_near + first);
    entered |= bits_of(kBoxes, hn::Le(enter, leave)) << first;
  }
  for (std::uint32_t i = 0; i < kBvh8Arity; ++i) {
    const std::uint32_t c = kQuery == Query::closest ? node.ordered(i, ray.octant) : i;
    stack.node[size] = node.child[c], stack.t_near[size] = t_near[c];
    size += entered >> c & 1u, places |= (entered >> c & 1u) << i;
  }
  return places;
#endif
}

// The triangles of one block of a leaf. Returns whether an any-hit query has its answer.
template <class Test, Query kQuery, class Node>
HWY_INLINE bool test_block(const Bvh8ViewOf<Node>& view, const typename Node::Block& block, const Ray& ray,
                           const typename Test::RayData& data, float t_min, Hit& hit) {
  TriangleBlock room;
  fetch_triangles(view, block, room);
  return BlockTest<Test>::template intersect<kQuery>(fetched(block, room), ray, data, t_min, hit);
}

// All of a leaf's.
template <class Test, Query kQuery, class Node>
HWY_INLINE bool intersect_leaf(const Bvh8ViewOf<Node>& view, NodeRef leaf, const Ray& ray, const typename Test::RayData& data,
                               float t_min, Hit& hit) {
  const auto* block = view.blocks + first_block(leaf);
  std::uint32_t left = counted_blocks(leaf);
  const bool is_counted = left != 0;
  do {
    if (!is_counted && !block->has(0)) return false;
    if (test_block<Test, kQuery>(view, *block, ray, data, t_min, hit)) return true;
    ++block;
  } while (!is_counted || --left != 0);
  return false;
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace accel
HWY_AFTER_NAMESPACE();

#endif
