// Laws: changes of the input whose effect on the answers is known. No oracle is needed to see that one is broken.
//
//   scale      the scene and the origins times 2^k, the directions likewise or not: the same bits but for t's exponent.
//   order      the triangles in another order: the same hits; among equals the lowest number wins.
//   axes       x, y and z exchanged in a cycle: the same hits.
//   union      the closest hit of two meshes together is the nearer one of theirs.
//   reversed   a segment from its other end meets the same set of triangles.
//   any        an any-hit query says yes where there is a closest hit, and nowhere else.
//   intervals  a hit at t is found by [0, t], [t, inf] and [t, t], and by no interval that ends or begins one float beside it.
//
// The first, the any-hit law and the ends of intervals hold for every bit of every ray. In the others the rounding of a
// triangle test may move a hit out of the box that holds its triangle, which one structure visits and another does not: such
// rays count as `different`, and are violations unless exact arithmetic excuses both answers (compare/judge.h). Moeller and
// Trumbore's test has no bound that could be asked: then only `different` is counted.
//
// Scenes: any that validate() accepts, with triangles that hits of the test under test are defined for; see has_range_for().
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "validation/compare/repro.h"
#include "validation/stress/stress_scenes.h"

namespace accel::validation {

enum class Law : std::uint8_t { scale, order, axes, unions, reversed, any, intervals };

// Who is asked.
struct LawSubject {
  std::string_view method, test;  // of the registry
  int threads = 1;

  bool is_watertight() const { return test == "watertight"; }
};

struct LawResult {
  std::uint64_t rays = 0;        // compared pairs of answers
  std::uint64_t different = 0;   // pairs that differ, for a reason or not
  std::uint64_t broken = 0;      // violations
  std::string what;              // the first one, in words
  std::vector<ReproCase> cases;  // the first few, with the answer that was expected as the witness's

  LawResult& operator+=(const LawResult& other);
};

// Whether the law can be asked on a scene of stress_scenes(): scaling takes the features of some out of the range of the
// triangle test.
bool has_range_for(Law law, const StressScene& scene);

// Errors: a build that fails.
Result<LawResult> check_law(Law law, const StressScene& scene, const std::vector<Ray>& rays, const LawSubject& subject);

}  // namespace accel::validation
