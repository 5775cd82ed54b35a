#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "libaccel/trace/bvh8_instances_simd.cpp"
#include <hwy/foreach_target.h>
// Above all other headers.
#include <hwy/highway.h>

#include <limits>

#include "libaccel/trace/bvh8_instances_simd.h"
#include "libaccel/trace/bvh8_interleaved_simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace accel {
namespace HWY_NAMESPACE {
namespace {

using Slabs = PaddedSlabs;

// A ray on its way, in the tree over instances or in that of a mesh.
struct InstanceFlight : Flight<Watertight, Slabs> {
  using Base = Flight<Watertight, Slabs>;
  static constexpr bool kHasInstances = true;
  static constexpr NodeRef kBottom = kInstanceBits | kMostInstances;  // of either tree's part of the stack; no instance
  static constexpr std::size_t stack_size(std::uint32_t depth) { return 2 * Base::stack_size(depth); }

  // What a ray leaves behind when it enters an instance.
  RayBoxes<Slabs> boxes_outside;
  Hit hit_outside;
  const Ray* ray_outside;
  const Bvh8Instance* instance;  // null: outside
  Ray ray_inside;

  HWY_INLINE const Ray* source() const { return instance != nullptr ? ray_outside : ray; }
  HWY_INLINE bool is_through() const { return ref == kBottom && instance == nullptr; }

  HWY_INLINE void begin(const Ray& r, const Slopes& slopes) {
    Base::begin(r, slopes);
    instance = nullptr;
  }

  // Into the instance that the ray has come to, or out of the one that it is in.
  template <Query kQuery>
  HWY_INLINE NodeRef change_trees(const TwoLevelBvh8View& view) {
    return is_instance(ref) ? enter(view, view.instances[instance_number(ref)]) : leave<kQuery>(view);
  }

 private:
  HWY_INLINE NodeRef enter(const TwoLevelBvh8View& view, const Bvh8Instance& next) {
    ray_inside = next.to_object.ray(*ray);
    Slopes slopes;
    if (HWY_UNLIKELY(!slopes.prepare(ray_inside))) return behind(view, next);
    boxes_outside = boxes, hit_outside = hit, ray_outside = ray, instance = &next;
    hit.prim_id = kNoHit;
    ray = &ray_inside;
    test = BlockTest<Watertight>::prepare(ray_inside);
    boxes = RayBoxes<Slabs>(ray_inside, slopes);
    stack.node[size] = kBottom, stack.t_near[size] = -std::numeric_limits<float>::infinity();
    ++size;
    return next.root;
  }

  // TwoLevel::or_leave(): hits are numbered as in the scene.
  template <Query kQuery>
  HWY_INLINE NodeRef leave(const TwoLevelBvh8View& view) {
    Hit found = hit;
    const Bvh8Instance& left = *instance;
    hit = hit_outside, boxes = boxes_outside, ray = ray_outside, instance = nullptr;
    if (found.valid()) {
      found.prim_id += left.first_prim;
      accept_hit(found, found.t, hit);
      if (kQuery == Query::any) return kBottom;
    }
    return behind(view, left);
  }

  // What comes after an instance.
  HWY_INLINE NodeRef behind(const TwoLevelBvh8View& view, const Bvh8Instance& before) {
    if (HWY_UNLIKELY(before.ends_leaf == 0)) return instance_ref(static_cast<std::uint32_t>(&before - view.instances) + 1);
    return stack.node[--size];
  }
};

// One ray, alone: the same steps.
template <Query kQuery>
HWY_INLINE Hit trace_one(const TwoLevelBvh8View& view, const Ray& ray, InstanceFlight& f) {
  Slopes slopes;
  if (!slopes.prepare(ray) || view.root == kNoNode) return Hit{};
  f.begin(ray, slopes);
  for (f.ref = view.root; !f.is_through();) {
    if (!is_leaf(f.ref))
      f.ref = f.descend<kQuery>(view);
    else if (!is_end(f.ref))
      f.ref = f.intersect<kQuery>(view, view.blocks[first_block(f.ref)]);
    else
      f.ref = f.change_trees<kQuery>(view);
  }
  finish_hit(f.hit);
  return f.hit;
}

template <Query kQuery, class Answer>
void trace(const TwoLevelBvh8View& view, const Ray* rays, std::size_t count, Answer* answers) {
  if (count >= kFewestInTurns) return trace_interleaved<InstanceFlight, kQuery>(view, rays, count, answers);
  constexpr std::size_t kEntries = InstanceFlight::stack_size(kMostBvh8Depth);
  NodeRef nodes[kEntries];
  float distances[kEntries];
  InstanceFlight f;
  f.begin_stack({nodes, distances}, f.kBottom);
  for (std::size_t i = 0; i < count; ++i) store_answer(trace_one<kQuery>(view, rays[i], f), answers[i]);
}

SimdFunctions<TwoLevelBvh8View> watertight() { return {trace<Query::closest, Hit>, trace<Query::any, std::uint8_t>}; }

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace accel
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace accel {
HWY_EXPORT(watertight);

SimdFunctions<TwoLevelBvh8View> Bvh8InstancesSimd<Watertight>::functions() { return HWY_DYNAMIC_DISPATCH(watertight)(); }
}  // namespace accel
#endif
