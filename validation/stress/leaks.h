// Leaks: rays at the edges and vertices of closed meshes, at one translation, from inside and from outside; exactly, where
// floats permit it, and one float beside them. Beside ours, Embree's robust and fast modes trace the same rays.
//
// What is wrong? From inside a ray must hit, whatever the vertices were rounded to: the degree of the rounded surface around
// the origin is that of the exact one. So no hit is a leak, beyond doubt. From outside a ray may pass a silhouette or meet
// another surface in front of its target, at t < 1. Exact arithmetic (compare/judge.h) judges what this does not explain: no
// hit, a hit behind the target, a hit far from the one that Embree found; and a seeded thousandth of all rays. Judged a miss,
// or too far, it leaked through the front side, or through both.
//
// Cost: what generating and tracing costs, and some 10 microseconds for each ray judged: a minute or two for 10^9 rays where
// nothing leaks. Embree's fast mode leaks so often that it gets a part of the rays only, and its number is told.
#pragma once

#include "validation/stress/run_case.h"

namespace accel::validation {

Result<StressOutcome> run_leaks(const StressCase& one, const StressRun& run);

}  // namespace accel::validation
