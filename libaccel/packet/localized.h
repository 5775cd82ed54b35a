// Localized intersection: the rays of packets against the leaves that their frustums meet. Garanzha and Loop 2010 [GL10],
// section 3.4, Fig. 10.
//
// A ray is tested against the triangles of a leaf if it enters the leaf's box before what it has hit so far; the box test is
// that of single rays (trace/box_pair.h), so that a ray meets the same triangles whatever packet it is in.
#pragma once

#include <cstdint>

#include "libaccel/core/hit.h"
#include "libaccel/packet/frustum.h"
#include "libaccel/packet/packet_options.h"
#include "libaccel/structure/bvh2.h"
#include "libaccel/trace/box_pair.h"
#include "libaccel/trace/leaf.h"
#include "libaccel/trace/traverser.h"

namespace accel {

// Packets with what their frustums meet. All rays of the packets can be traced.
struct LocalizedBatch {
  const OctoNode* nodes;
  const LeafQuad* leaves;
  const Ray* rays;
  const std::uint32_t* ids;      // the order of rays: rays[ids[0]], rays[ids[1]], ...
  const std::uint32_t* packets;  // packet p has the rays ids[packets[p]] to ids[packets[p + 1] - 1]
  const std::uint32_t* active;   // the packets that meet anything, by number
  const Frustum* frustums;       // of active packet i
  const std::uint32_t* firsts;   // active packet i has the places firsts[i] to firsts[i + 1] - 1
  std::size_t count;             // of active packets
  const std::uint32_t* places;   // of leaves: see FrustumQueue
};

// Whether a ray enters the box of a leaf before t_max: BoxPairTest for one box.
ACCEL_HD bool enters(const OctoNode& node, std::uint32_t c, const ScalarBoxPairTest& ray, float t_max) {
  float enter = ray.t_min, leave = t_max;
  for (int a = 0; a < 3; ++a) {
    const bool backwards = ray.near_at[a] != 0;
    const float near_t = ((backwards ? node.upper[a][c] : node.lower[a][c]) - ray.org[a]) * ray.inv_near[a];
    const float far_t = ((backwards ? node.lower[a][c] : node.upper[a][c]) - ray.org[a]) * ray.inv_far[a];
    enter = max_of(near_t, enter), leave = min_of(far_t, leave);
  }
  return enter <= leave * kFarScale;
}

// One ray against the leaves in order: what a thread of [GL10]'s kernel does. For any-hit queries, hit.valid() is the answer.
template <class Test, Query kQuery, class Observer>
ACCEL_HD Hit intersect_leaves(const OctoNode* nodes, const LeafQuad* leaves, const Ray& ray, const std::uint32_t* places,
                              std::uint32_t count, Observer& observer) {
  Hit hit;
  begin_hit(ray, hit);
  const float t_min = first_t(ray);
  const auto box = ScalarBoxPairTest::prepare(ray, t_min);
  const auto data = Test::prepare(ray);
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t place = leaf_quad(places[i]), c = place % kOctoArity;
    const OctoNode& node = nodes[place / kOctoArity];
    observer.box_tests(1);
    if (!enters(node, c, box, hit.t)) continue;
    std::uint32_t quad = leaf_quad(node.child[c]);
    observer.leaf_visit(quad);
    Phase phase = Phase::intersect;
    while (phase == Phase::intersect)
      phase = intersect_next<Test, kQuery>(leaves, ray, data, t_min, quad, hit, Phase::backtrack, observer);
    if (phase == Phase::done) break;
  }
  finish_hit(hit);
  return hit;
}

// All rays of active packets: answers[i] answers rays[i]; nothing else is written.
template <class Test, Query kQuery, class Answer>
void intersect_packets(const LocalizedBatch& batch, Answer* answers) {
  NullObserver observer;
  for (std::size_t i = 0; i < batch.count; ++i) {
    const std::uint32_t packet = batch.active[i], first = batch.firsts[i];
    for (std::uint32_t at = batch.packets[packet]; at < batch.packets[packet + 1]; ++at) {
      const std::uint32_t id = batch.ids[at];
      const Hit hit = intersect_leaves<Test, kQuery>(batch.nodes, batch.leaves, batch.rays[id], batch.places + first,
                                                     batch.firsts[i + 1] - first, observer);
      store_answer(hit, answers[id]);
    }
  }
}

}  // namespace accel
