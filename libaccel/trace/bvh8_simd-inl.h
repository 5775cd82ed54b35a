// The code of trace/bvh8_simd.h, for every node layout, box test and triangle test: sources that instantiate it for some of
// them include this. The guard lets the header through once for each target that Highway compiles.
#if defined(ACCEL_BVH8_SIMD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ACCEL_BVH8_SIMD_INL_H
#undef ACCEL_BVH8_SIMD_INL_H
#else
#define ACCEL_BVH8_SIMD_INL_H
#endif

#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>

#include "libaccel/trace/bvh8_interleaved_simd-inl.h"
#include "libaccel/trace/bvh8_node_simd-inl.h"
#include "libaccel/trace/bvh8_simd.h"

HWY_BEFORE_NAMESPACE();
namespace accel {
namespace HWY_NAMESPACE {
namespace {

// The child in the last of the places whose bits are set. A branch for each place, no look-up: a branch that is predicted names
// the next node before the boxes of this one have been tested, and the next node's test begins at once.
template <Query kQuery, class Node, std::uint32_t kPlace = kBvh8Arity - 1>
HWY_INLINE NodeRef nearest_child(const Node& node, std::uint32_t octant, std::uint32_t places) {
  if constexpr (kPlace > 0)
    if ((places & 1u << kPlace) == 0) return nearest_child<kQuery, Node, kPlace - 1>(node, octant, places);
  return node.child[kQuery == Query::closest ? node.ordered(kPlace, octant) : kPlace];
}

// One ray, alone. Its stack has room for the deepest tree.
template <class Test, class Slabs, Query kQuery, class Node>
HWY_INLINE Hit trace_one(const Bvh8ViewOf<Node>& view, const Ray& ray, Postponed stack) {
  Hit hit;
  begin_hit(ray, hit);
  Slopes slopes;
  if (!slopes.prepare(ray) || view.root == kNoNode) return Hit{};
  const typename Test::RayData data = BlockTest<Test>::prepare(ray);
  const RayBoxes<Slabs> boxes(ray, slopes);
  NodeRef ref = view.root;
  std::size_t size = 0;
  for (;;) {
    if (!is_leaf(ref)) {
      const Node& node = view.nodes[ref];
      const std::uint32_t places = push_children<kQuery>(node, boxes, scaled_end<Slabs>(hit.t), stack, size);
      if (places != 0) {
        --size;
        ref = nearest_child<kQuery>(node, boxes.octant, places);
        continue;
      }
    } else if (intersect_leaf<Test, kQuery>(view, ref, ray, data, boxes.t_min, hit)) {
      return hit;
    }
    do {
      if (size == 0) {
        finish_hit(hit);
        return hit;
      }
      --size;
    } while (kQuery == Query::closest && !(stack.t_near[size] <= scaled_end<Slabs>(hit.t)));
    ref = stack.node[size];
  }
}

template <class Test, class Slabs, Query kQuery, class Node, class Answer>
void trace(const Bvh8ViewOf<Node>& view, const Ray* rays, std::size_t count, Answer* answers) {
  if (count >= kFewestInTurns) return trace_interleaved<Flight<Test, Slabs>, kQuery>(view, rays, count, answers);
  NodeRef nodes[bvh8_stack_size(kMostBvh8Depth)];
  float distances[bvh8_stack_size(kMostBvh8Depth)];
  for (std::size_t i = 0; i < count; ++i)
    store_answer(trace_one<Test, Slabs, kQuery>(view, rays[i], {nodes, distances}), answers[i]);
}

// What a source exports.
template <class Node, class Slabs, class Test>
Bvh8Functions<Node> functions_of() {
  return {trace<Test, Slabs, Query::closest, Node, Hit>, trace<Test, Slabs, Query::any, Node, std::uint8_t>};
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace accel
HWY_AFTER_NAMESPACE();

#endif
