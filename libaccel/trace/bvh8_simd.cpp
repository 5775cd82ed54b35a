#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "libaccel/trace/bvh8_simd.cpp"
#include <hwy/foreach_target.h>
// Above all other headers.
#include <hwy/highway.h>

#include <bit>
#include <cstddef>
#include <limits>

#include "libaccel/trace/bvh8_ray.h"
#include "libaccel/trace/bvh8_simd.h"
#include "libaccel/trace/triangle_block_simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace accel {
namespace HWY_NAMESPACE {
namespace {

const hn::CappedTag<float, kBvh8Arity> kBoxes;
const hn::RebindToUnsigned<decltype(kBoxes)> kRefs;
using Boxes = decltype(hn::Zero(kBoxes));

// What is postponed, and room for a vector behind it.
struct Stack {
  alignas(64) NodeRef node[bvh8_stack_size(kMostBvh8Depth)];
  alignas(64) float t_near[bvh8_stack_size(kMostBvh8Depth)];
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
      hn::Store(hn::Mul(inv, set(Bvh8Ray::kScale)), kTriangles, inv_far + i);
      const auto good = hn::And(hn::Le(hn::Abs(o), most_coordinate), hn::Le(hn::Abs(d), most_coordinate));
      in_range |= bits_of(kTriangles, good) << i;
      moves |= bits_of(kTriangles, hn::Not(is_zero)) << i;
      backwards |= bits_of(kTriangles, hn::Lt(inv, set(0))) << i;
    }
    octant = backwards & 7u;
    return (in_range & 7u) == 7u && (moves & 7u) != 0 && ray.t_min <= ray.t_max && ray.t_max >= 0;
  }
};

// The box test of a ray, in as many vectors as eight boxes make.
struct RayBoxes {
  Boxes org[3], inv_near[3], inv_far[3], t_min;
  std::size_t near_at[3];  // where near planes are in a node, in floats
  std::uint32_t octant;

  HWY_INLINE RayBoxes(const Ray& ray, const Slopes& slopes) {
    for (int a = 0; a < 3; ++a) {
      org[a] = hn::Set(kBoxes, (&ray.org.x)[a]);
      inv_near[a] = hn::Set(kBoxes, slopes.inv_near[a]), inv_far[a] = hn::Set(kBoxes, slopes.inv_far[a]);
      near_at[a] = (slopes.octant >> a & 1u) * kBvh8Arity;
    }
    t_min = hn::Set(kBoxes, first_t(ray));
    octant = slopes.octant;
  }

  // Where the children from `first` on are entered, and left.
  HWY_INLINE void meet(const Bvh8Node& node, std::size_t first, Boxes limit, Boxes& enter, Boxes& leave) const {
    Boxes nearer[3], farther[3];
    for (int a = 0; a < 3; ++a) {
      const float* const planes = node.planes[a][0] + first;
      nearer[a] = hn::Mul(hn::Sub(hn::Load(kBoxes, planes + near_at[a]), org[a]), inv_near[a]);
      farther[a] = hn::Mul(hn::Sub(hn::Load(kBoxes, planes + (near_at[a] ^ kBvh8Arity)), org[a]), inv_far[a]);
    }
    enter = most(most(nearer[1], nearer[2]), most(nearer[0], t_min));
    leave = least(least(farther[1], farther[2]), least(farther[0], limit));
  }
};

// The child in the last of the places whose bits are set. A branch for each place, no look-up: a branch that is predicted names
// the next node before the boxes of this one have been tested, and the next node's test begins at once. Where rays resemble
// each other that makes traversal half as fast again; where nothing can be predicted it costs a tenth.
template <Query kQuery, std::uint32_t kPlace = kBvh8Arity - 1>
HWY_INLINE NodeRef nearest_child(const Bvh8Node& node, std::uint32_t octant, std::uint32_t places) {
  if constexpr (kPlace > 0)
    if ((places & 1u << kPlace) == 0) return nearest_child<kQuery, kPlace - 1>(node, octant, places);
  return node.child[kQuery == Query::closest ? node.ordered(kPlace, octant) : kPlace];
}

// Postpones the children that the ray enters. Returns whether `nearest`, with kPredict, is one that comes next instead.
template <Query kQuery, bool kPredict>
HWY_INLINE bool push_children(const Bvh8Node& node, const RayBoxes& ray, float limit, Stack& stack, std::size_t& size,
                              NodeRef& nearest) {
#if HWY_TARGET <= HWY_AVX2 && HWY_ARCH_X86
  Boxes enter, leave;
  ray.meet(node, 0, hn::Set(kBoxes, limit), enter, leave);
  auto refs = hn::Load(kRefs, node.child);
  if constexpr (kQuery == Query::closest) {
    const auto order =
        hn::And(hn::ShiftRightSame(hn::Load(kRefs, node.order), static_cast<int>(3 * ray.octant)), hn::Set(kRefs, 7u));
    const auto in_order = hn::IndicesFromVec(kBoxes, order);
    enter = hn::TableLookupLanes(enter, in_order), leave = hn::TableLookupLanes(leave, in_order);
    refs = hn::TableLookupLanes(refs, hn::IndicesFromVec(kRefs, order));
  }
  const auto entered = hn::Le(enter, leave);
  if constexpr (kQuery == Query::closest) hn::StoreU(hn::Compress(enter, entered), kBoxes, stack.t_near + size);
  hn::StoreU(hn::Compress(refs, hn::RebindMask(kRefs, entered)), kRefs, stack.node + size);
  const std::uint32_t places = bits_of(kBoxes, entered);
  size += static_cast<std::size_t>(std::popcount(places));
  if (!kPredict || places == 0) return false;
  --size;
  nearest = nearest_child<kQuery>(node, ray.octant, places);
  return true;
#else
  alignas(64) float t_near[kBvh8Arity];
  std::uint32_t entered = 0;
  for (std::size_t first = 0; first < kBvh8Arity; first += hn::Lanes(kBoxes)) {
    Boxes enter, leave;
    ray.meet(node, first, hn::Set(kBoxes, limit), enter, leave);
    hn::Store(enter, kBoxes, t_near + first);
    entered |= bits_of(kBoxes, hn::Le(enter, leave)) << first;
  }
  for (std::uint32_t i = 0; i < kBvh8Arity; ++i) {
    const std::uint32_t c = kQuery == Query::closest ? node.ordered(i, ray.octant) : i;
    stack.node[size] = node.child[c], stack.t_near[size] = t_near[c];
    size += entered >> c & 1u;
  }
  if (!kPredict || entered == 0) return false;
  nearest = stack.node[--size];
  return true;
#endif
}

// A leaf's triangles. Returns whether an any-hit query has its answer.
template <Query kQuery>
HWY_INLINE bool intersect_leaf(const Bvh8View& view, NodeRef leaf, const Ray& ray, const Watertight::RayData& data, float t_min,
                               Hit& hit) {
  const TriangleBlock* block = view.blocks + first_block(leaf);
  std::uint32_t left = counted_blocks(leaf);
  const bool is_counted = left != 0;
  do {
    if (!is_counted && !block->has(0)) return false;
    if (intersect_block<kQuery>(*block, ray, data, t_min, hit)) return true;
    ++block;
  } while (!is_counted || --left != 0);
  return false;
}

template <Query kQuery, bool kPredict>
HWY_INLINE Hit trace_one(const Bvh8View& view, const Ray& ray, Stack& stack) {
  Hit hit;
  begin_hit(ray, hit);
  Slopes slopes;
  if (!slopes.prepare(ray) || view.root == kNoNode) return Hit{};
  const Watertight::RayData data = prepare_watertight(ray);
  const RayBoxes boxes(ray, slopes);
  const float t_min = first_t(ray);
  NodeRef ref = view.root;
  std::size_t size = 0;
  for (;;) {
    if (!is_leaf(ref)) {
      if (push_children<kQuery, kPredict>(view.nodes[ref], boxes, scaled_end(hit.t), stack, size, ref)) continue;
    } else if (intersect_leaf<kQuery>(view, ref, ray, data, t_min, hit)) {
      return hit;
    }
    do {
      if (size == 0) {
        finish_hit(hit);
        return hit;
      }
      --size;
    } while (kQuery == Query::closest && !(stack.t_near[size] <= scaled_end(hit.t)));
    ref = stack.node[size];
  }
}

template <Query kQuery, bool kPredict, class Answer>
HWY_INLINE void trace_all(const Bvh8View& view, const Ray* rays, std::size_t count, Answer* answers) {
  Stack stack;
  for (std::size_t i = 0; i < count; ++i) store_answer(trace_one<kQuery, kPredict>(view, rays[i], stack), answers[i]);
}

void intersect(const Bvh8View& view, const Ray* rays, std::size_t count, bool predict, Hit* hits) {
  if (predict)
    trace_all<Query::closest, true>(view, rays, count, hits);
  else
    trace_all<Query::closest, false>(view, rays, count, hits);
}
void occlude(const Bvh8View& view, const Ray* rays, std::size_t count, bool predict, std::uint8_t* occluded) {
  if (predict)
    trace_all<Query::any, true>(view, rays, count, occluded);
  else
    trace_all<Query::any, false>(view, rays, count, occluded);
}

const char* target_name() { return hwy::TargetName(HWY_TARGET); }

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace accel
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace accel {
HWY_EXPORT(intersect);
HWY_EXPORT(occlude);
HWY_EXPORT(target_name);

namespace {

bool are_alike(const Ray& a, const Ray& b) {
  const auto dot = [](Vec3 v, Vec3 w) {
    return static_cast<double>(v.x) * w.x + static_cast<double>(v.y) * w.y + static_cast<double>(v.z) * w.z;
  };
  const double ab = dot(a.dir, b.dir);
  return ab > 0 && ab * ab > 0.9 * dot(a.dir, a.dir) * dot(b.dir, b.dir);
}

// Whether most rays run nearly as the one before, in a sample of some dozens.
bool are_alike(std::span<const Ray> rays) {
  const std::size_t stride = rays.size() / 64 + 1;
  int alike = 0;
  for (std::size_t i = 1; i < rays.size(); i += stride) alike += are_alike(rays[i - 1], rays[i]) ? 1 : -1;
  return alike >= 0;
}

}  // namespace

void intersect_bvh8_simd(const Bvh8View& view, std::span<const Ray> rays, std::span<Hit> hits) {
  HWY_DYNAMIC_DISPATCH(intersect)(view, rays.data(), rays.size(), are_alike(rays), hits.data());
}
void occlude_bvh8_simd(const Bvh8View& view, std::span<const Ray> rays, std::span<std::uint8_t> occluded) {
  HWY_DYNAMIC_DISPATCH(occlude)(view, rays.data(), rays.size(), are_alike(rays), occluded.data());
}
const char* bvh8_simd_target() { return HWY_DYNAMIC_DISPATCH(target_name)(); }
}  // namespace accel
#endif
