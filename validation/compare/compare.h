// Compares a batch of answers with a witness's, lets the judge decide where they differ, and counts.
//
// Where ours and the witness's agree (Judge::agree) a ray counts as `agree`, and a seeded sample of these is judged as well,
// since both may be wrong. All other rays are judged; without a witness, all are. So agreement with the witness is not
// correctness, and disagreement not an error: `failures` counts only what exact arithmetic proves.
//
// The result depends on the input and the seed only, not on the number of threads. Cost: some 10 microseconds a judged ray,
// some 0.1 an agreeing one.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "libaccel/core/progress.h"
#include "libaccel/core/result.h"
#include "validation/compare/judge.h"

namespace accel::validation {

struct CompareOptions {
  std::uint64_t seed = 1;
  double sample_share = 0.01;     // of all rays: judged even where the witness agrees
  std::uint64_t max_judged = 0;   // 0: no limit. Where it binds, disagreeing rays come first, evenly spread over the batch
  int threads = 0;                // 0: as many as the machine has
  bool keep_verdicts = false;     // fill CheckResult::verdicts
  std::size_t max_failures = 16;  // how many of ours to list
  Progress progress;              // phase "check"
};

// Of one engine. `agree` counts all agreeing rays, whether judged or not; the verdicts from `right` on add up to `judged`.
struct Verdicts {
  std::uint64_t agree = 0, judged = 0;
  std::uint64_t right = 0, neighbour = 0, edge = 0, miss = 0, far = 0, false_hit = 0;

  std::uint64_t failures() const { return miss + far + false_hit; }
  void count(Verdict verdict);
  bool operator==(const Verdicts&) const = default;
};

// Of the judged rays, with a witness. An answer counts as right here unless it is a failure: neighbour and edge are answers
// that rounding excuses.
struct Adjudication {
  std::uint64_t both_right = 0, only_ours_right = 0, only_witness_right = 0, both_wrong = 0;
};

// How far our hits with verdict `right` are from the exact ones. The mean and the percentiles are of the seeded sample, the
// maxima of all judged rays.
//
// A unit in the last place is the spacing of floats at t*, or the change of t when the largest coordinate of the origin moves
// by the spacing of floats there, whichever is larger. Without the second, a ray that starts on a surface (t* near 0) would
// count errors that no arithmetic on its origin can avoid in units of nearly nothing, and such rays alone would make the mean.
struct HitErrors {
  std::uint64_t samples = 0;  // behind the mean and the percentiles
  double t_ulp_mean = 0, t_ulp_p50 = 0, t_ulp_p99 = 0, t_ulp_max = 0;
  double barycentric_max = 0;  // of |u - u*| and |v - v*|
};

struct Failure {
  std::size_t ray;
  Verdict verdict;
};

// Events per million trials. Where there were none, `bound95` is 3 / N, below which the true rate lies with 95 % confidence
// (the rule of three), and never more than a million; otherwise it equals the rate. NaN where nothing was tried.
struct Rate {
  double per_million = std::numeric_limits<double>::quiet_NaN();
  double bound95_per_million = std::numeric_limits<double>::quiet_NaN();
};
Rate rate(std::uint64_t events, std::uint64_t trials);

struct CheckResult {
  std::uint64_t rays = 0;
  bool has_witness = false;
  Verdicts ours, witness;                 // the witness's are zero without a witness
  Adjudication adjudication;              // likewise
  HitErrors errors;                       // closest hits only
  std::uint64_t unjudged = 0;             // disagreeing rays that the limit left out: 0 unless it binds
  std::vector<Failure> first_failures;    // of ours, in order of rays
  std::vector<Verdict> verdicts;          // of ours by ray; `agree` or `unjudged` where not judged. Only if asked for
  std::vector<Verdict> witness_verdicts;  // likewise; only with a witness

  std::uint64_t failures() const { return ours.failures(); }
  bool limit_binds() const { return unjudged > 0; }
  // Of all rays, of which those are taken as right that the witness agrees on. Where the limit binds, the disagreeing rays that
  // were judged stand for all of these: they are spread evenly.
  Rate rate_of(std::uint64_t events) const;
};

// Closest hits. `ours` has one hit a ray, and so has `witness` unless it is empty.
// Errors: spans of different sizes; "interrupted".
Result<CheckResult> compare(const Judge& judge, std::span<const Ray> rays, std::span<const Hit> ours,
                            std::span<const Hit> witness, const CompareOptions& options = {});

// Any-hit answers, nonzero where occluded.
Result<CheckResult> compare_any(const Judge& judge, std::span<const Ray> rays, std::span<const std::uint8_t> ours,
                                std::span<const std::uint8_t> witness, const CompareOptions& options = {});

}  // namespace accel::validation
