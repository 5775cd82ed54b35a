// Several hits of a ray, or those behind one that is known, by any traverser: triangle tests that keep what they find.
//
// Order. Hits are ordered by t, and by prim_id where t is the same. A triangle has one t for a ray, bit for bit, in whatever
// leaf of whatever structure it is met, so that its place in the order names it: a triangle that several leaves hold is found
// once, and "the hits behind this one" needs no more than its t and prim_id.
//
// Keeping hits. What a traverser knows of hits is the end of the interval that is still of interest, hit.t. Collect<Test> is a
// triangle test that puts what Test finds into a buffer of the k nearest and reports nothing, as if the triangle were not met.
// Only while the buffer is full it reports what gets in, at the t of the farthest hit that is in: the traverser then culls
// behind that, by its own rules, and no traverser needs to know. Its own hit means nothing in the end. (Gribble, Naveros and
// Kerzner 2014, "Multi-Hit Ray Traversal", and Amstutz et al. 2015 have buffers of the same kind, inside of the traversal.)
//
// Going on. After<Test> finds nothing but what is behind a given hit. With t_min at that hit's t a closest-hit query names the
// next hit: boxes that the ray leaves there still count, since intervals are closed.
//
// The data of both tests are made by prepare() as if there were nothing to keep and nothing to be behind of. Who drives the
// traverser sets them after begin(), which tests no triangles: see ray_data(), and exec/multi_hit.h. Instances
// (trace/two_level.h) hand them on, with the number that makes prim_ids those of the scene.
//
// Cost of a buffer of k: O(1) for a triangle behind the k nearest, O(k) for one that gets in.
#pragma once

#include <cstdint>

#include "libaccel/geometry/packed_triangle.h"
#include "libaccel/trace/traverser.h"

namespace accel {

// A place in the order of hits.
struct HitPlace {
  float t;
  std::uint32_t prim_id;
};

ACCEL_HD HitPlace place_of(const Hit& hit) { return {hit.t, hit.prim_id}; }

// False where either t is NaN.
ACCEL_HD bool is_before(HitPlace a, HitPlace b) { return a.t < b.t || (a.t == b.t && a.prim_id < b.prim_id); }

// In front of all hits: they have no negative t.
inline constexpr HitPlace kBeforeAllHits{-1.0f, kNoHit};

// The hits of one ray that are nearest behind `after`: in order, each once.
struct HitBuffer {
  Hit* hits;
  std::uint32_t capacity;  // at least 1
  std::uint32_t count;
  float t_min, t_max;  // the interval, both ends included
  HitPlace after;

  ACCEL_HD static HitBuffer prepare(const Ray& ray, HitPlace after, Hit* hits, std::uint32_t capacity) {
    Hit whole;
    begin_hit(ray, whole);
    return {hits, capacity, 0, first_t(ray), whole.t, after};
  }

  ACCEL_HD bool is_full() const { return count == capacity; }

  // Takes a hit, unless it is outside of the interval, not behind `after`, behind all hits of a full buffer, or here already.
  ACCEL_HD bool take(const Hit& hit) {
    const HitPlace place = place_of(hit);
    if (!(hit.t >= t_min && hit.t <= t_max) || !is_before(after, place)) return false;
    if (is_full() && !is_before(place, place_of(hits[count - 1]))) return false;
    std::uint32_t at = count;
    while (at > 0 && is_before(place, place_of(hits[at - 1]))) --at;
    if (at > 0 && !is_before(place_of(hits[at - 1]), place)) return false;
    if (!is_full()) ++count;
    for (std::uint32_t i = count - 1; i > at; --i) hits[i] = hits[i - 1];
    hits[at] = hit;
    return true;
  }
};

template <class Test>
struct Collect {
  struct RayData : Test::RayData {
    HitBuffer* buffer;
    std::uint32_t first_prim;  // of the instance that the ray is in

    ACCEL_HD void enter_instance(const RayData& outside, std::uint32_t first) { buffer = outside.buffer, first_prim = first; }
  };

  ACCEL_HD static RayData prepare(const Ray& ray) { return {Test::prepare(ray), nullptr, 0}; }

  ACCEL_HD static bool intersect(const PackedTriangle& triangle, const Ray& ray, const RayData& data, Hit& hit) {
    if (!Test::intersect(triangle, ray, data, hit)) return false;
    hit.prim_id = data.first_prim + triangle.prim_id();
    HitBuffer& buffer = *data.buffer;
    if (!buffer.take(hit) || !buffer.is_full()) return false;
    hit.t = buffer.hits[buffer.count - 1].t;
    return true;
  }
};

template <class Test>
struct After {
  struct RayData : Test::RayData {
    HitPlace after;
    std::uint32_t first_prim;

    ACCEL_HD void enter_instance(const RayData& outside, std::uint32_t first) { after = outside.after, first_prim = first; }
  };

  ACCEL_HD static RayData prepare(const Ray& ray) { return {Test::prepare(ray), kBeforeAllHits, 0}; }

  ACCEL_HD static bool intersect(const PackedTriangle& triangle, const Ray& ray, const RayData& data, Hit& hit) {
    return Test::intersect(triangle, ray, data, hit) && is_before(data.after, {hit.t, data.first_prim + triangle.prim_id()});
  }
};

// The test's data in the state of a traverser; with instances, those of the level that it is on.
template <class State>
ACCEL_HD auto& ray_data(State& state) {
  if constexpr (requires { state.active; })
    return state.active.test;
  else
    return state.test;
}

// The ray from a hit on. A ray that is none stays none.
ACCEL_HD Ray behind(const Ray& ray, HitPlace after) {
  Ray rest = ray;
  if (after.t > ray.t_min) rest.t_min = after.t;
  return rest;
}

}  // namespace accel
