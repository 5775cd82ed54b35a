#include "apps/common/measure.h"

#include <algorithm>
#include <ctime>

namespace accel::apps {

namespace {

Result<double> trace_part(const Engine& engine, std::span<const Ray> rays, Query query, Answers& answers, std::size_t begin,
                          std::size_t count) {
  const auto part = rays.subspan(begin, count);
  return query == Query::closest ? engine.closest(part, answers.hits.span().subspan(begin, count))
                                 : engine.occluded(part, answers.occluded.span().subspan(begin, count));
}

double cpu_seconds() {
  std::timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

Speed speed_of(const std::vector<Measurement::Pass>& passes, std::size_t rays) {
  if (passes.empty() || rays == 0) return {};
  std::vector<double> seconds;
  for (const Measurement::Pass& pass : passes) seconds.push_back(pass.seconds);
  const auto [least, most] = std::minmax_element(seconds.begin(), seconds.end());
  const auto mrays = [&](double s) { return static_cast<double>(rays) * 1e-6 / std::max(s, 1e-9); };
  return {mrays(median(seconds)), mrays(*most), mrays(*least)};
}

std::optional<std::uint64_t> count_of(const InstructionCounter* counter) {
  return counter == nullptr ? std::nullopt : counter->count();
}

// One pass. Fills the answers and returns what tracing took. While `learn`, calls grow until one takes long enough
// for its overhead not to matter.
Result<Measurement::Pass> trace_once(Engine& engine, std::span<const Ray> rays, Query query, Answers& answers, bool learn,
                                     const InstructionCounter* counter, const Progress& progress) {
  constexpr double kLongEnough = 0.1;
  Measurement::Pass pass;
  std::size_t count = 0;
  for (std::size_t begin = 0; begin < rays.size(); begin += count) {
    if (!progress({}, static_cast<double>(begin) / static_cast<double>(rays.size()))) return Error{std::string(kInterrupted)};
    count = std::min(engine.rays_per_call, rays.size() - begin);
    const double cpu_start = cpu_seconds();
    const auto counted_before = count_of(counter);
    const auto spent = trace_part(engine, rays, query, answers, begin, count);
    if (!spent) return spent.error();
    const auto counted_after = count_of(counter);
    pass.seconds += *spent, pass.cpu_seconds += cpu_seconds() - cpu_start;
    if (counted_before && counted_after) pass.instructions = pass.instructions.value_or(0) + *counted_after - *counted_before;
    if (learn && *spent < kLongEnough)
      engine.rays_per_call = std::max(engine.rays_per_call, std::min(4 * engine.rays_per_call, Engine::kLongestCall));
  }
  return pass;
}

}  // namespace

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n % 2 == 1 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

std::optional<double> Measurement::instructions() const {
  std::vector<double> counts;
  for (const Pass& pass : passes)
    if (pass.instructions) counts.push_back(static_cast<double>(*pass.instructions));
  return counts.empty() ? std::nullopt : std::optional(median(std::move(counts)));
}

Engine engine_of(const AnyAccel& accel, const TraceOptions& options) {
  Engine engine;
  engine.name = accel.method().name;
  engine.closest = [=](std::span<const Ray> rays, std::span<Hit> hits) {
    return timed([&] { return accel.closest(rays, hits, options); });
  };
  engine.occluded = [=](std::span<const Ray> rays, std::span<std::uint8_t> occluded) {
    return timed([&] { return accel.occluded(rays, occluded, options); });
  };
  return engine;
}

Outcome<std::vector<Measurement>> measure(std::span<Engine> engines, std::span<const Ray> rays, Query query, int repeat,
                                          ProgressBar& bar, const InstructionCounter* counter) {
  std::vector<Measurement> results(engines.size());
  const std::size_t total = engines.size() * (static_cast<std::size_t>(repeat) + 1);
  std::size_t done = 0;
  for (int r = 0; r <= repeat; ++r) {
    for (std::size_t turn = 0; turn < engines.size(); ++turn, ++done) {
      const std::size_t e = (turn + static_cast<std::size_t>(r)) % engines.size();
      Measurement& result = results[e];
      if (r == 0) result.answers = Answers(query, rays.size());
      const std::span<const Ray> traced = engines[e].own_rays.empty() ? rays : engines[e].own_rays;
      const auto progress = [&](std::string_view, double fraction) {
        return bar.update(engines[e].name, (static_cast<double>(done) + fraction) / static_cast<double>(total));
      };
      const auto taken = trace_once(engines[e], traced, query, result.answers, r == 0, counter, progress);
      if (!taken) return taken.error();
      if (r > 0) result.passes.push_back(*taken);
    }
  }
  for (Measurement& result : results) result.speed = speed_of(result.passes, rays.size());
  return results;
}

}  // namespace accel::apps
