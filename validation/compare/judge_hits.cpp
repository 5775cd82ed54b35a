#include "validation/compare/judge_hits.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "libaccel/trace/multi_hit.h"
#include "validation/compare/must_hit.h"

namespace accel::validation {
namespace {

enum class HitVerdict : std::uint8_t { right, edge, false_hit };

// Whether rounding leaves no doubt that a hit is in the interval.
bool is_surely_inside(const Ray& ray, const TriangleBounds& b) { return b.t_lo >= first_t(ray) && b.t_hi <= last_t(ray); }

HitVerdict judge_one(const Judge& judge, const Ray& ray, const Hit& hit) {
  if (!is_traceable(ray) || !is_plausible(ray, hit) || !judge.oracle().is_known(hit.prim_id)) return HitVerdict::false_hit;
  const TriangleBounds b = judge.bounds(ray, hit.prim_id);
  if (!b.allows(hit.t)) return HitVerdict::false_hit;
  return b.near_any_edge() || !is_surely_inside(ray, b) ? HitVerdict::edge : HitVerdict::right;
}

// Whether triangles that are not in the list must be hit in front of t_end.
bool is_missing_hits(const Judge& judge, const Ray& ray, std::span<const Hit> hits, double t_end) {
  if (!is_traceable(ray)) return false;
  std::vector<std::uint32_t> listed;
  for (const Hit& hit : hits) listed.push_back(hit.prim_id);
  std::sort(listed.begin(), listed.end());
  MustHit evidence;
  const ExactOracle& oracle = judge.oracle();
  for (const std::uint32_t prim : oracle.near(ray, kNearPadding, t_end)) {
    if (std::binary_search(listed.begin(), listed.end(), prim)) continue;
    const TriangleBounds b = judge.bounds(ray, prim);
    if (b.possible && is_surely_inside(ray, b) && b.t_hi < t_end && oracle.can_be_hit(prim))
      evidence.add(oracle.local_triangle(prim), b, oracle.instance_number(prim));
  }
  return evidence.decide();
}

}  // namespace

HitsVerdict& HitsVerdict::operator+=(const HitsVerdict& other) {
  right += other.right, edge += other.edge, false_hit += other.false_hit;
  miss += other.miss, disorder += other.disorder;
  return *this;
}

HitsVerdict judge_hits(const Judge& judge, const Ray& ray, std::span<const Hit> hits, double t_end) {
  HitsVerdict verdict;
  bool ordered = true;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (i > 0) ordered &= is_before(place_of(hits[i - 1]), place_of(hits[i]));
    const HitVerdict v = judge_one(judge, ray, hits[i]);
    ++(v == HitVerdict::right ? verdict.right : v == HitVerdict::edge ? verdict.edge : verdict.false_hit);
  }
  verdict.disorder = ordered ? 0 : 1;
  verdict.miss = is_missing_hits(judge, ray, hits, t_end) ? 1 : 0;
  return verdict;
}

HitsVerdict judge_hits(const Judge& judge, const Ray& ray, std::span<const Hit> hits) {
  return judge_hits(judge, ray, hits, std::numeric_limits<double>::infinity());
}

}  // namespace accel::validation
