#include "validation/compare/judge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "libaccel/core/float_bounds.h"
#include "libaccel/trace/traverser.h"
#include "validation/compare/must_hit.h"

namespace accel::validation {
namespace {

// Whether two ranges of t meet.
bool overlap(const TriangleBounds& a, const TriangleBounds& b) { return a.t_lo <= b.t_hi && b.t_lo <= a.t_hi; }

}  // namespace

double last_t(const Ray& ray) { return std::min(ray.t_max, std::numeric_limits<float>::max()); }

bool is_plausible(const Ray& ray, const Hit& hit) {
  const bool inside = hit.t >= first_t(ray) && hit.t <= last_t(ray);  // false for NaN
  return inside && std::isfinite(hit.u) && std::isfinite(hit.v);
}

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
  if (!oracle_.is_known(hit.prim_id) || !is_traceable(ray) || !is_plausible(ray, hit)) return Verdict::false_hit;

  const TriangleBounds allowed = bounds(ray, hit.prim_id);
  const bool behind = exact.valid() && hit.t > exact.t;
  if (!allowed.possible) return Verdict::false_hit;
  if (!allowed.allows(hit.t)) return behind ? Verdict::far : Verdict::false_hit;
  if (exact.contains(hit.prim_id)) return Verdict::right;

  const auto meets = [&](std::uint32_t prim) { return overlap(allowed, bounds(ray, prim)); };
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
  if (!oracle_.is_known(a.prim_id) || !is_traceable(ray) || !is_plausible(ray, a) || !is_plausible(ray, b)) return false;
  const TriangleBounds allowed = bounds(ray, a.prim_id);
  return allowed.allows(a.t) && allowed.allows(b.t);
}

TriangleBounds Judge::bounds(const Ray& ray, std::uint32_t prim) const {
  const Instance* const instance = oracle_.instance_of(prim);
  return {instance != nullptr ? RayFrame(ray, instance->transform) : RayFrame(ray), oracle_.local_triangle(prim)};
}

// Whether a watertight test must find a hit in the interval up to t_end.
bool Judge::must_hit(const Ray& ray, double t_end) const {
  if (!is_traceable(ray)) return false;
  MustHit evidence;
  for (const std::uint32_t prim : oracle_.near(ray, kNearPadding, t_end)) {
    const TriangleBounds b = bounds(ray, prim);
    const bool certain_t = b.t_lo >= first_t(ray) && b.t_hi <= last_t(ray) && b.t_hi <= t_end;
    if (b.possible && certain_t && oracle_.can_be_hit(prim))
      evidence.add(oracle_.local_triangle(prim), b, oracle_.instance_number(prim));
  }
  return evidence.decide();
}

// Whether rounding may find a hit in the interval.
bool Judge::may_hit(const Ray& ray) const {
  if (!is_traceable(ray)) return false;
  const std::vector<std::uint32_t> prims = oracle_.near(ray, kNearPadding, last_t(ray));
  return std::any_of(prims.begin(), prims.end(), [&](std::uint32_t prim) {
    const TriangleBounds b = bounds(ray, prim);
    return b.possible && b.t_hi >= first_t(ray) && b.t_lo <= last_t(ray);
  });
}

}  // namespace accel::validation
