// The judge: what an engine's answer is worth against the exact one.
//
// An engine that rounds cannot always name an exact hit, and need not: within the backward-error bound of error_bounds.h an
// answer is as good as any other. Beyond it, it is wrong. The verdicts:
//
//   right      a miss where nothing is hit; or a primitive that is hit at exactly the nearest t*, and t within its bound.
//   neighbour  another primitive, which the ray passes within its bound, and whose bound of t meets that of the exact hit: the
//              other side of a shared edge, or a surface too near to another to be told apart.
//   edge       a hit in front of t*, or where nothing is hit, on a primitive that the ray passes within its bound; or a
//              miss, or a hit behind t*, where a watertight test may miss: see below.
//   miss       no hit where a watertight test must find one.
//   far        a hit behind a hit that a watertight test must find; or one whose t is beyond t* and outside its bound.
//   false      a hit on a primitive that the ray does not pass within its bound; or one whose t is not beyond t* and
//              outside its bound; or one outside the ray's interval, or whose u or v is no finite number.
//
// miss, far and false are failures.
//
// May it be missed? Being near an edge excuses nothing: a ray through an interior edge or vertex of a mesh that gets through is
// a leak. What a watertight test promises is to round every vertex once, in the same way for all triangles that use it, and
// then to accept every closed triangle that contains the ray. So a miss is inexcusable if every way of moving the vertices
// within their bounds leaves the ray in some triangle, and excused if that cannot be proved. Let N be the triangles that are
// possible for the ray and whose range of t lies wholly inside the ray's interval (and, for a hit that may be too far, before
// that hit). Project along the ray. Take any set x of triangles of N in whose boundary, taken modulo 2, no edge is near the
// ray: every near edge belongs to an even number of them. While the vertices move within their bounds, only near edges touch
// the ray; they come in pairs, so their contributions cancel, and the winding number of x around the ray modulo 2 does not
// change (the degree of a map is a homotopy invariant as long as the boundary stays clear of the point). If it is odd, then
// every way of moving leaves the ray inside some triangle of x: the ray must hit. With the rows of A the near edges, the
// columns the triangles of N, and c the parities of the triangles' windings,
//
//   must hit  <=  there is an x over GF(2) with A x = 0 and c . x = 1  <=>  c is not in the row space of A,
//
// which Gaussian elimination decides. A triangle that is near no edge and contains the ray is the simplest case; the fan around
// an interior vertex another. The parity of a triangle counts the crossings of its three edges with a half-axis by a half-open
// rule whose bit for an edge does not depend on the triangle. Edges are pairs of positions, not of indices: meshes duplicate
// vertices. Triangles without an area are left out: builders drop them. (A hit on one is judged like any other, by whether the
// ray passes it within its bound.)
//
// The promise is the ideal one. A test that rejects a triangle whose three edge functions all round to zero, or a structure
// whose boxes are not padded for the movement of vertices, may break it in rare cases: that is then a miss like any other.
//
// Instances are judged in their own spaces, where their triangles are tested; error_bounds.h has what the rounding of the ray
// adds. Sums of windings over several instances are sums of sums, each of which is zero or not by itself, so that the argument
// holds for all instances together, with rows for the near edges of each.
//
// Any-hit answers: right where they are; an occluded ray that hits nothing is an edge if some triangle is possible with a t
// that may lie in the interval, else false; an unoccluded one that hits is a miss if it must hit, else an edge.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "libaccel/core/hit.h"
#include "validation/compare/error_bounds.h"
#include "validation/oracle/exact.h"

namespace accel::validation {

// `agree` and `unjudged` are for rays that the judge did not see.
enum class Verdict : std::uint8_t { right, neighbour, edge, miss, far, false_hit, agree, unjudged };
inline constexpr int kVerdicts = 8;

constexpr bool is_failure(Verdict v) { return v == Verdict::miss || v == Verdict::far || v == Verdict::false_hit; }
std::string_view to_string(Verdict verdict);

// The end of the interval in which a hit may lie.
double last_t(const Ray& ray);
// Whether t is in the interval, and u and v are numbers.
bool is_plausible(const Ray& ray, const Hit& hit);

// Queries are const and may run on any number of threads.
class Judge {
 public:
  // The mesh satisfies validate().
  explicit Judge(const TriangleMesh& mesh) : oracle_(mesh) {}
  explicit Judge(const InstancedMeshes& scene) : oracle_(scene) {}

  const ExactOracle& oracle() const { return oracle_; }

  // What rounding may make of a triangle for a traceable ray; its coordinates are in range.
  TriangleBounds bounds(const Ray& ray, std::uint32_t prim) const;

  // `exact` is oracle().closest(ray).
  Verdict judge(const Ray& ray, const Hit& hit, const ExactHit& exact) const;

  // `exact` is oracle().any(ray).
  Verdict judge_any(const Ray& ray, bool occluded, bool exact) const;

  // Whether two closest hits are the same answer: both misses, or the same primitive with both t within its bound, and both
  // plausible.
  bool agree(const Ray& ray, const Hit& a, const Hit& b) const;

 private:
  Verdict judge_hit(const Ray& ray, const Hit& hit, const ExactHit& exact) const;
  bool must_hit(const Ray& ray, double t_end) const;
  bool may_hit(const Ray& ray) const;

  ExactOracle oracle_;
};

}  // namespace accel::validation
