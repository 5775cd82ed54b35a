// Localized intersection as a traverser (trace/traverser.h): a ray against the leaves that the frustum of its packet meets.
// Garanzha and Loop 2010, section 3.4, Fig. 10. The same steps in the same order as intersect_leaves() (packet/localized.h),
// one at a time, so that a model of a machine can run them (exec/simt.h).
//
// A view belongs to one packet; rays of several packets take several calls. descend() tests the box of the next leaf,
// intersect() one triangle of it; there is nothing to come back to, hence no backtrack().
#pragma once

#include <cstdint>

#include "libaccel/packet/localized.h"

namespace accel {

// The leaves that a packet's frustum meets, from front to back: see FrustumQueue.
struct PacketLeaves {
  const OctoNode* nodes = nullptr;
  const LeafQuad* leaves = nullptr;
  const std::uint32_t* places = nullptr;
  std::uint32_t count = 0;
};

// The first triangle of the leaf of a place, if the ray enters its box before t_max, else kNoNode.
template <class Observer>
ACCEL_HD std::uint32_t enter_leaf(const OctoNode* nodes, const std::uint32_t* at, const ScalarBoxPairTest& ray, float t_max,
                                  Observer& observer) {
  const std::uint32_t place = leaf_quad(*at), c = place % kOctoArity;
  const OctoNode& node = nodes[place / kOctoArity];
  observer.load(Memory::node, at, sizeof *at);
  for (int a = 0; a < 3; ++a) {
    observer.load(Memory::node, &node.lower[a][c], sizeof(float));
    observer.load(Memory::node, &node.upper[a][c], sizeof(float));
  }
  observer.box_tests(1);
  if (!enters(node, c, ray, t_max)) return kNoNode;
  observer.load(Memory::node, &node.child[c], sizeof(NodeRef));
  const std::uint32_t quad = leaf_quad(node.child[c]);
  observer.leaf_visit(quad);
  return quad;
}

template <class Test, Query kQuery>
struct LocalizedRay {
  static constexpr const char* kName = "localized";
  using View = PacketLeaves;
  struct State {
    ScalarBoxPairTest boxes;
    typename Test::RayData test;
    std::uint32_t next;  // leaf
    std::uint32_t quad;  // in a leaf
  };

  template <class Observer>
  ACCEL_HD static Phase begin(const View& view, const Ray& ray, State& state, Hit& hit, Observer&) {
    begin_hit(ray, hit);
    if (view.count == 0 || !is_traceable(ray)) return Phase::done;
    state.boxes = ScalarBoxPairTest::prepare(ray, first_t(ray));
    state.test = Test::prepare(ray);
    state.next = 0;
    return Phase::descend;
  }

  template <class Observer>
  ACCEL_HD static Phase descend(const View& view, const Ray&, State& state, Hit& hit, Observer& observer) {
    state.quad = enter_leaf(view.nodes, view.places + state.next++, state.boxes, hit.t, observer);
    return state.quad == kNoNode ? after_leaf(view, state) : Phase::intersect;
  }

  template <class Observer>
  ACCEL_HD static Phase intersect(const View& view, const Ray& ray, State& s, Hit& hit, Observer& observer) {
    return intersect_next<Test, kQuery>(view.leaves, ray, s.test, s.boxes.t_min, s.quad, hit, after_leaf(view, s), observer);
  }

  template <class Observer>
  ACCEL_HD static Phase backtrack(const View&, const Ray&, State&, Hit&, Observer&) {
    return Phase::done;
  }

 private:
  ACCEL_HD static Phase after_leaf(const View& view, const State& state) {
    return state.next < view.count ? Phase::descend : Phase::done;
  }
};

}  // namespace accel
