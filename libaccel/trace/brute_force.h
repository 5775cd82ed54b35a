// Every triangle against the ray: no structure, no traversal. The twin that all methods are compared with.
#pragma once

#include "libaccel/structure/triangle_list.h"
#include "libaccel/trace/leaf.h"

namespace accel {

template <class Test, Query kQuery>
struct BruteForce {
  static constexpr const char* kName = "loop";
  static constexpr bool kIsExhaustive = true;
  using View = TriangleListView;

  struct State {
    typename Test::RayData test;
    float t_min;
    std::uint32_t quad;
  };

  template <class Observer>
  ACCEL_HD static Phase begin(const View& view, const Ray& ray, State& state, Hit& hit, Observer& observer) {
    begin_hit(ray, hit);
    if (view.leaves == nullptr || is_end_of_leaf(view.leaves, 0) || !is_traceable(ray)) return Phase::done;
    state.test = Test::prepare(ray), state.t_min = first_t(ray), state.quad = 0;
    observer.leaf_visit(0);
    return Phase::intersect;
  }
  template <class Observer>
  ACCEL_HD static Phase descend(const View&, const Ray&, State&, Hit&, Observer&) {
    return Phase::done;
  }
  template <class Observer>
  ACCEL_HD static Phase intersect(const View& view, const Ray& ray, State& s, Hit& hit, Observer& observer) {
    return intersect_next<Test, kQuery>(view.leaves, ray, s.test, s.t_min, s.quad, hit, Phase::done, observer);
  }
  template <class Observer>
  ACCEL_HD static Phase backtrack(const View&, const Ray&, State&, Hit&, Observer&) {
    return Phase::done;
  }
};

}  // namespace accel
