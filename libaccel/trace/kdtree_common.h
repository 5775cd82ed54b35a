// What the traversers of the kd-tree share: where a ray meets planes, and how it enters nodes.
//
// Everything that a traverser decides about a plane rests on one number, the rounded distance (plane - org) * inv_dir, always
// computed by crossing(), and on one rule (Foley and Sugerman 2005, Fig. 2, search-split):
//
//     not distance > t_min      the second child alone     (the one that the ray reaches later)
//     not distance < t_max      the first child alone
//     else                      the first child up to the distance, then the second child from there
//
// The distance is monotone in the plane, so the intervals of cells follow one another without gaps or overlaps, and the
// interval of a cell is the same whether it is found by descent from the root, or from the cell's faces, as the traversers
// without a stack do: bit for bit. Each interval has a length: two planes that are crossed at one distance have no cell
// between them. (An interval that is a single point from the start visits one cell.)
//
// A direction component of zero, of either sign, counts as positive: its distances are +inf for planes above the origin, -inf
// for planes below it, and NaN for a plane through it, of which the rule keeps the second child: the origin's side.
//
// A hit is final when the leaf's interval ends behind it: structure/kdtree.h says why all triangles that could be nearer are
// then among those already tested.
#pragma once

#include <bit>
#include <cstdint>
#include <limits>

#include "libaccel/structure/kdtree.h"
#include "libaccel/trace/reference_leaf.h"
#include "libaccel/trace/traverser.h"

namespace accel {

// The ray as planes see it.
struct KdRay {
  float org[3];
  float inv_dir[3];  // +inf for zero of either sign

  ACCEL_HD static KdRay prepare(const Ray& ray) {
    KdRay result;
    for (int a = 0; a < 3; ++a) {
      result.org[a] = ray.org[a];
      result.inv_dir[a] = ray.dir[a] == 0 ? std::numeric_limits<float>::infinity() : 1.0f / ray.dir[a];
    }
    return result;
  }

  ACCEL_HD float crossing(int axis, float plane) const {
    return (plane - element_of_three(org, axis)) * element_of_three(inv_dir, axis);
  }

  // 1 where the ray runs towards smaller coordinates, else 0.
  ACCEL_HD std::uint32_t backwards(int axis) const {
    return std::bit_cast<std::uint32_t>(element_of_three(inv_dir, axis)) >> 31;
  }

  // The faces through which the ray enters and leaves boxes.
  ACCEL_HD float entry_face(const Aabb& box, int axis) const { return backwards(axis) != 0 ? box.hi[axis] : box.lo[axis]; }
  ACCEL_HD float exit_face(const Aabb& box, int axis) const { return backwards(axis) != 0 ? box.lo[axis] : box.hi[axis]; }

  // Where the ray leaves a box that it is in, t_end at the latest. A face that contains the ray (NaN) does not end it.
  ACCEL_HD float exit(const Aabb& box, float t_end) const {
    for (int a = 0; a < 3; ++a) t_end = min_of(crossing(a, exit_face(box, a)), t_end);
    return t_end;
  }
  ACCEL_HD float entry(const Aabb& box, float t_begin) const {
    for (int a = 0; a < 3; ++a) t_begin = max_of(crossing(a, entry_face(box, a)), t_begin);
    return t_begin;
  }
};

// What every traverser of the kd-tree carries.
template <class Test>
struct KdState {
  KdRay planes;
  typename Test::RayData test;
  float t_min, t_max;       // the ray's interval in the current node
  KdNode node;              // while descending
  std::uint32_t reference;  // in a leaf
};

// Prepares hit and state. False for rays that miss the scene's box.
template <class Test>
ACCEL_HD bool begin_kdtree(const KdTreeView& view, const Ray& ray, KdState<Test>& state, Hit& hit) {
  begin_hit(ray, hit);
  if (view.nodes == nullptr || !is_traceable(ray)) return false;
  state.planes = KdRay::prepare(ray);
  state.t_min = state.planes.entry(view.bounds, first_t(ray));
  state.t_max = state.planes.exit(view.bounds, hit.t);
  state.test = Test::prepare(ray);
  return state.t_min <= state.t_max;
}

// Where the ray meets the plane of an inner node, and the child on whose side it is before.
struct KdCrossing {
  float t;
  std::uint32_t first;
  ACCEL_HD std::uint32_t second() const { return first ^ 1u; }
};
ACCEL_HD KdCrossing crossing(const KdRay& ray, KdNode node) {
  return {ray.crossing(node.axis(), node.plane()), node.lower_child() + ray.backwards(node.axis())};
}

// Reaches the leaf that state.node is, and tells the phase that it calls for.
template <class Test, class Observer>
ACCEL_HD Phase enter_leaf(std::uint32_t index, KdState<Test>& state, Observer& observer) {
  observer.leaf_visit(index);
  state.reference = state.node.first_reference();
  return state.reference == kEmptyLeaf ? Phase::backtrack : Phase::intersect;
}

template <class Test, class Observer>
ACCEL_HD void load_node(const KdTreeView& view, std::uint32_t index, KdState<Test>& state, Observer& observer) {
  state.node = load_8_bytes(view.nodes[index]);
  observer.load(Memory::node, view.nodes + index, sizeof(KdNode));
}

// Goes to a node, and tells the phase that it calls for.
template <class Test, class Observer>
ACCEL_HD Phase enter(const KdTreeView& view, std::uint32_t index, KdState<Test>& state, Observer& observer) {
  load_node(view, index, state, observer);
  return state.node.is_leaf() ? enter_leaf(index, state, observer) : Phase::descend;
}

// Whether no triangle beyond the current leaf can be met before the hit, or before the end of the ray.
template <class Test>
ACCEL_HD bool is_final(const Hit& hit, const KdState<Test>& state) {
  return hit.t <= state.t_max;
}

}  // namespace accel
