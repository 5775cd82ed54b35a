#include "validation/compare/compare.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "libaccel/core/counter_rng.h"
#include "libaccel/exec/cpu.h"

namespace accel::validation {
namespace {

// The judge's work on one ray. Errors are NaN where there is nothing to measure.
struct Judgement {
  Verdict ours = Verdict::unjudged, witness = Verdict::unjudged;
  double t_ulp = std::numeric_limits<double>::quiet_NaN();
  double barycentric = std::numeric_limits<double>::quiet_NaN();
};

// The spacing of floats at t.
double ulp(double t) {
  const int exponent = std::max(std::ilogb(std::abs(t)), -126);
  return t == 0 ? 0x1p-149 : std::ldexp(1.0, exponent - 23);
}

// The unit in which an error of t is measured: see HitErrors.
double t_unit(const Ray& ray, double t) {
  const double org = std::max({std::abs(ray.org.x), std::abs(ray.org.y), std::abs(ray.org.z)});
  const double dir = std::max({std::abs(ray.dir.x), std::abs(ray.dir.y), std::abs(ray.dir.z)});
  return std::max(ulp(t), ulp(org) / dir);
}

// `count` of the values, evenly spread.
std::vector<std::size_t> thin_out(const std::vector<std::size_t>& values, std::size_t count) {
  std::vector<std::size_t> kept(count);
  for (std::size_t i = 0; i < count; ++i) kept[i] = values[i * values.size() / count];
  return kept;
}

// What closest and any have in common: the witness's agreement, the choice of rays, the loop, the tally.
//
// Answers has: size(), has_witness(), agree(i), judge(i).
template <class Answers>
class Comparison {
 public:
  Comparison(const Answers& answers, const CompareOptions& options) : answers_(answers), options_(options) {}

  Result<CheckResult> run() {
    result_.rays = answers_.size(), result_.has_witness = answers_.has_witness();
    find_agreement();
    choose();
    if (!judge_chosen()) return Error{std::string(kInterrupted)};
    tally();
    return std::move(result_);
  }

 private:
  void find_agreement() {
    agrees_.assign(answers_.size(), 0);
    if (!answers_.has_witness()) return;
    for_each_block(answers_.size(), options_.threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) agrees_[i] = answers_.agree(i);
    });
    result_.ours.agree = static_cast<std::uint64_t>(std::count(agrees_.begin(), agrees_.end(), 1));
    result_.witness.agree = result_.ours.agree;
  }

  // Whether a ray belongs to the sample of all rays that is judged whatever the witness says.
  bool in_sample(std::size_t ray) const {
    return !answers_.has_witness() || CounterRng(options_.seed, ray).next_double() < options_.sample_share;
  }

  // Fills chosen_: the disagreeing rays and a sample of the agreeing ones, within the limit, in order.
  void choose() {
    std::vector<std::size_t> sample;
    for (std::size_t i = 0; i < answers_.size(); ++i) {
      if (!agrees_[i]) {
        chosen_.push_back(i);
      } else if (in_sample(i)) {
        sample.push_back(i);
      }
    }
    const std::size_t limit = options_.max_judged == 0 ? answers_.size() : options_.max_judged;
    if (chosen_.size() > limit) {
      result_.unjudged = chosen_.size() - limit;
      chosen_ = thin_out(chosen_, limit);
    }
    sample = thin_out(sample, std::min(sample.size(), limit - chosen_.size()));
    chosen_.insert(chosen_.end(), sample.begin(), sample.end());
    std::sort(chosen_.begin(), chosen_.end());
  }

  // Returns false when the caller's progress function asks to stop.
  bool judge_chosen() {
    constexpr std::size_t kChunk = 16384;
    constexpr auto kReportInterval = std::chrono::milliseconds(200);
    auto last_report = std::chrono::steady_clock::now();
    judgements_.resize(chosen_.size());
    for (std::size_t first = 0; first < chosen_.size(); first += kChunk) {
      const std::size_t count = std::min(kChunk, chosen_.size() - first);
      for_each_block(count, options_.threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = first + begin; i < first + end; ++i) judgements_[i] = answers_.judge(chosen_[i]);
      });
      const auto now = std::chrono::steady_clock::now();
      if (!options_.progress || now - last_report < kReportInterval) continue;
      last_report = now;
      if (!options_.progress("check", static_cast<double>(first + count) / static_cast<double>(chosen_.size()))) return false;
    }
    return true;
  }

  void tally() {
    if (options_.keep_verdicts) start_verdict_maps();
    for (std::size_t i = 0; i < chosen_.size(); ++i) {
      const Judgement& j = judgements_[i];
      result_.ours.count(j.ours);
      if (is_failure(j.ours) && result_.first_failures.size() < options_.max_failures) {
        result_.first_failures.push_back({chosen_[i], j.ours});
      }
      if (options_.keep_verdicts) result_.verdicts[chosen_[i]] = j.ours;
      if (!answers_.has_witness()) continue;
      result_.witness.count(j.witness);
      adjudicate(!is_failure(j.ours), !is_failure(j.witness));
      if (options_.keep_verdicts) result_.witness_verdicts[chosen_[i]] = j.witness;
    }
    measure_errors();
  }

  void start_verdict_maps() {
    result_.verdicts.resize(answers_.size());
    for (std::size_t i = 0; i < answers_.size(); ++i) result_.verdicts[i] = agrees_[i] ? Verdict::agree : Verdict::unjudged;
    if (answers_.has_witness()) result_.witness_verdicts = result_.verdicts;
  }

  void adjudicate(bool ours, bool witness) {
    Adjudication& a = result_.adjudication;
    ++(ours ? witness ? a.both_right : a.only_ours_right : witness ? a.only_witness_right : a.both_wrong);
  }

  void measure_errors() {
    std::vector<double> t_ulp;  // of the sample
    HitErrors& errors = result_.errors;
    for (std::size_t i = 0; i < chosen_.size(); ++i) {
      const Judgement& j = judgements_[i];
      if (std::isnan(j.t_ulp)) continue;
      errors.t_ulp_max = std::max(errors.t_ulp_max, j.t_ulp);
      errors.barycentric_max = std::max(errors.barycentric_max, j.barycentric);
      if (!in_sample(chosen_[i])) continue;
      t_ulp.push_back(j.t_ulp);
      errors.t_ulp_mean += j.t_ulp;
    }
    errors.samples = t_ulp.size();
    if (t_ulp.empty()) return;
    errors.t_ulp_mean /= static_cast<double>(t_ulp.size());
    // Nearest-rank percentiles: the smallest value that so many of a hundred samples do not exceed.
    const auto percentile = [&](std::size_t percent) {
      const std::size_t rank = (percent * t_ulp.size() + 99) / 100 - 1;
      std::nth_element(t_ulp.begin(), t_ulp.begin() + static_cast<std::ptrdiff_t>(rank), t_ulp.end());
      return t_ulp[rank];
    };
    errors.t_ulp_p50 = percentile(50), errors.t_ulp_p99 = percentile(99);
  }

  const Answers& answers_;
  const CompareOptions& options_;
  std::vector<std::uint8_t> agrees_;
  std::vector<std::size_t> chosen_;
  std::vector<Judgement> judgements_;
  CheckResult result_;
};

struct ClosestAnswers {
  const Judge& referee;
  std::span<const Ray> rays;
  std::span<const Hit> ours, witness;

  std::size_t size() const { return rays.size(); }
  bool has_witness() const { return !witness.empty(); }
  bool agree(std::size_t i) const { return referee.agree(rays[i], ours[i], witness[i]); }

  Judgement judge(std::size_t i) const {
    const ExactHit exact = referee.oracle().closest(rays[i]);
    Judgement result;
    result.ours = referee.judge(rays[i], ours[i], exact);
    if (has_witness()) result.witness = referee.judge(rays[i], witness[i], exact);
    if (result.ours != Verdict::right || !exact.valid()) return result;
    result.t_ulp = std::abs(ours[i].t - exact.t) / t_unit(rays[i], exact.t);
    if (const auto point = referee.oracle().point(rays[i], ours[i].prim_id)) {
      result.barycentric = std::max(std::abs(ours[i].u - point->u), std::abs(ours[i].v - point->v));
    }
    return result;
  }
};

struct AnyAnswers {
  const Judge& referee;
  std::span<const Ray> rays;
  std::span<const std::uint8_t> ours, witness;

  std::size_t size() const { return rays.size(); }
  bool has_witness() const { return !witness.empty(); }
  bool agree(std::size_t i) const { return (ours[i] != 0) == (witness[i] != 0); }

  Judgement judge(std::size_t i) const {
    const bool exact = referee.oracle().any(rays[i]);
    Judgement result;
    result.ours = referee.judge_any(rays[i], ours[i] != 0, exact);
    if (has_witness()) result.witness = referee.judge_any(rays[i], witness[i] != 0, exact);
    return result;
  }
};

template <class Answers>
Result<CheckResult> run(const Answers& answers, const CompareOptions& options) {
  if (answers.ours.size() != answers.rays.size()) {
    return Error{std::to_string(answers.ours.size()) + " answers for " + std::to_string(answers.rays.size()) + " rays"};
  }
  if (answers.has_witness() && answers.witness.size() != answers.rays.size()) {
    return Error{"the witness has " + std::to_string(answers.witness.size()) + " answers for " +
                 std::to_string(answers.rays.size()) + " rays"};
  }
  return Comparison<Answers>(answers, options).run();
}

}  // namespace

void Verdicts::count(Verdict verdict) {
  ++judged;
  switch (verdict) {
    case Verdict::right:
      ++right;
      break;
    case Verdict::neighbour:
      ++neighbour;
      break;
    case Verdict::edge:
      ++edge;
      break;
    case Verdict::miss:
      ++miss;
      break;
    case Verdict::far:
      ++far;
      break;
    case Verdict::false_hit:
      ++false_hit;
      break;
    case Verdict::agree:
    case Verdict::unjudged:
      ACCEL_ASSERT(false);
      break;
  }
}

Result<CheckResult> compare(const Judge& judge, std::span<const Ray> rays, std::span<const Hit> ours,
                            std::span<const Hit> witness, const CompareOptions& options) {
  return run(ClosestAnswers{judge, rays, ours, witness}, options);
}

Result<CheckResult> compare_any(const Judge& judge, std::span<const Ray> rays, std::span<const std::uint8_t> ours,
                                std::span<const std::uint8_t> witness, const CompareOptions& options) {
  return run(AnyAnswers{judge, rays, ours, witness}, options);
}

Rate CheckResult::rate_of(std::uint64_t events) const {
  const std::uint64_t disagreeing = rays - ours.agree, judged = disagreeing - unjudged;
  if (unjudged == 0) return rate(events, rays);
  // As many rays as have that many disagreeing ones.
  return rate(events, judged == 0
                          ? 0
                          : static_cast<std::uint64_t>(std::llround(static_cast<double>(rays) * static_cast<double>(judged) /
                                                                    static_cast<double>(disagreeing))));
}

Rate rate(std::uint64_t events, std::uint64_t trials) {
  if (trials == 0) return {};
  const double scale = 1e6 / static_cast<double>(trials);
  const double per_million = static_cast<double>(events) * scale;
  return {per_million, events == 0 ? std::min(3 * scale, 1e6) : per_million};
}

}  // namespace accel::validation
