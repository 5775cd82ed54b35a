// The stress suite: every case by name, what it traces, and what is expected of every method of the registry with the
// watertight test. run_case.h runs them: a few rays each for ctest, any number for `accel-trace stress`.
//
// Names are FAMILY/CASE. Families: rays (kinds of rays, through a few scenes), geometry (scenes, with rays of all kinds), laws
// (laws.h), leaks (rays at edges and vertices of closed meshes, from inside and from outside, at one translation each).
//
// Where single precision ends, the case says so: its numbers are printed beside Embree's, and nothing but an end is expected.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "libaccel/core/result.h"
#include "validation/stress/laws.h"
#include "validation/stress/ray_kinds.h"
#include "validation/stress/stress_geometry.h"

namespace accel::validation {

enum class Expected : std::uint8_t {
  clean,            // no answer is judged a miss, too far or false, and any-hit queries agree with closest hits
  all_misses,       // nothing is hit
  build_error,      // the builder refuses the input, with a message
  first_of_copies,  // the bits of brute force over the first of all copies
  lawful,           // the law is never broken
  no_leak,          // as clean, and every ray from inside hits
  measured,         // nothing: numbers are printed
};

struct StressCase {
  std::string_view name;
  std::string_view what;         // what is traced
  std::string_view expectation;  // what must come of it, in words
  Expected expected;
  SceneMaker scenes = nullptr;  // null for leaks: closed_meshes.h
  RayKind rays = RayKind::mixed;
  Law law = Law::any;                 // of laws
  double offset = 0;                  // of leaks: the translation in units of the mesh
  std::uint64_t most_large_rays = 0;  // through large scenes, where a ray meets very many triangles; 0: no limit

  std::string_view family() const { return name.substr(0, name.find('/')); }
};

std::span<const StressCase> stress_cases();

// The cases of a name or of a family; an error suggests a name.
Result<std::vector<const StressCase*>> find_cases(std::string_view name);

}  // namespace accel::validation
