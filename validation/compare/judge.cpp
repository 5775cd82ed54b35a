#include "validation/compare/judge.h"

#include <algorithm>
#include <array>

#include "libaccel/core/float_bounds.h"
#include "libaccel/trace/traverser.h"
#include "validation/compare/must_hit.h"

namespace accel::validation {
namespace {

// The end of the interval in which a hit may lie.
double last_t(const Ray& ray) { return std::min(ray.t_max, std::numeric_limits<float>::max()); }

// Whether two ranges of t meet.
bool overlap(const TriangleBounds& a, const TriangleBounds& b) { return a.t_lo <= b.t_hi && b.t_lo <= a.t_hi; }

}  // namespace

std::string_view to_string(Verdict verdict) {
  constexpr std::array<std::string_view, kVerdicts> kNames{"right", "neighbour", "edge",  "miss",
                                                           "far",   "false",     "agree", "unjudged"};
  return kNames[static_cast<std::size_t>(verdict)];
}

Verdict Judge::judge(const Ray& ray, const Hit& hit, const ExactHit& exact) const {
  if (hit.valid()) return judge_hit(ray, hit, exact);
  if (!exact.valid()) return Verdict::right;
  return must_hit(ray, last_t(ray)) ? Verdict::miss : Verdict::edge;
}

Verdict Judge::judge_hit(const Ray& ray, const Hit& hit, const ExactHit& exact) const {
  const bool inside = hit.t >= first_t(ray) && hit.t <= last_t(ray);  // false for NaN
  if (!is_known(hit.prim_id) || !is_traceable(ray) || !inside) return Verdict::false_hit;

  const RayFrame frame(ray);
  const TriangleBounds bounds(frame, mesh().triangle(hit.prim_id));
  const bool behind = exact.valid() && hit.t > exact.t;
  if (!bounds.possible) return Verdict::false_hit;
  if (!bounds.allows(hit.t)) return behind ? Verdict::far : Verdict::false_hit;
  if (exact.contains(hit.prim_id)) return Verdict::right;

  const auto meets = [&](std::uint32_t prim) { return overlap(bounds, {frame, mesh().triangle(prim)}); };
  if (std::any_of(exact.prims.begin(), exact.prims.end(), meets)) return Verdict::neighbour;
  return behind && must_hit(ray, next_down(hit.t)) ? Verdict::far : Verdict::edge;
}

Verdict Judge::judge_any(const Ray& ray, bool occluded, bool exact) const {
  if (occluded == exact) return Verdict::right;
  if (exact) return must_hit(ray, last_t(ray)) ? Verdict::miss : Verdict::edge;
  return may_hit(ray) ? Verdict::edge : Verdict::false_hit;
}

bool Judge::agree(const Ray& ray, const Hit& a, const Hit& b) const {
  if (a.prim_id != b.prim_id) return false;
  if (!a.valid()) return true;
  if (!is_known(a.prim_id) || !is_traceable(ray)) return false;
  const TriangleBounds bounds(RayFrame(ray), mesh().triangle(a.prim_id));
  return bounds.allows(a.t) && bounds.allows(b.t);
}

// Whether there is such a triangle, with coordinates that may be computed with.
bool Judge::is_known(std::uint32_t prim) const {
  if (prim >= mesh().size()) return false;
  const Triangle t = mesh().triangle(prim);
  return in_range(t.v0) && in_range(t.v1) && in_range(t.v2);
}

// Whether a watertight test must find a hit in the interval up to t_end.
bool Judge::must_hit(const Ray& ray, double t_end) const {
  if (!is_traceable(ray)) return false;
  const RayFrame frame(ray);
  MustHit evidence;
  for (const std::uint32_t prim : oracle_.near(ray, kNearPadding, t_end)) {
    const Triangle triangle = mesh().triangle(prim);
    const TriangleBounds bounds(frame, triangle);
    const bool certain_t = bounds.t_lo >= first_t(ray) && bounds.t_hi <= last_t(ray) && bounds.t_hi <= t_end;
    if (bounds.possible && certain_t && oracle_.can_be_hit(prim)) evidence.add(triangle, bounds);
  }
  return evidence.decide();
}

// Whether rounding may find a hit in the interval.
bool Judge::may_hit(const Ray& ray) const {
  if (!is_traceable(ray)) return false;
  const RayFrame frame(ray);
  const std::vector<std::uint32_t> prims = oracle_.near(ray, kNearPadding, last_t(ray));
  return std::any_of(prims.begin(), prims.end(), [&](std::uint32_t prim) {
    const TriangleBounds bounds(frame, mesh().triangle(prim));
    return bounds.possible && bounds.t_hi >= first_t(ray) && bounds.t_lo <= last_t(ray);
  });
}

}  // namespace accel::validation
