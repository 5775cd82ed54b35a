// accel-trace --sweep: run time against error, of every combination of method, triangle test, box test and node precision.
//
// The plane. A configuration costs nanoseconds a ray and has an error: wrong hits per million, the higher of the rates of the
// rays at hand and of edge rays, which find what ordinary rays seldom meet. Where no wrong hit was found the rate is 0, and
// below 3 / N with 95 % confidence. A point is on the front if no other of its kind of rays is as fast and as good, and better
// in one of both.
//
// Advice. What the library promises, robust methods with the first triangle test, goes before what merely made no error here:
// the fastest promised configuration is recommended, or with --max-error the fastest whose error is known to be within it, and
// the fastest of all is named beside it with its error.
#pragma once

#include <string>
#include <vector>

#include "apps/common/method_set.h"
#include "apps/common/trace_options.h"
#include "apps/common/trace_report.h"

namespace accel::apps {

// A method with a triangle test: what is timed and checked.
struct Configuration {
  const MethodSet::Member* member;
  std::string test;  // empty: the first
  bool promised;     // wrong hits are failures
};

// Those of a run: every method with the test that was asked for or, in a sweep, with all that make sense. Others are noted.
std::vector<Configuration> configurations(const MethodSet& set, const TraceSettings& settings, std::vector<Skip>& skipped);

// Places the rows of a sweep on the plane of their kind of rays, and finds advice for each kind.
void place_on_plane(TraceReport& report, const TraceSettings& settings);

// Tables of the fronts, with the promised configurations and Embree beside them, and the advice.
std::string sweep_section(const TraceReport& report, const TraceSettings& settings, const Terminal& terminal);

}  // namespace accel::apps
