#include "libaccel/packet/bvh8_stream.h"

#include <time.h>

#include <algorithm>
#include <array>
#include <limits>

#include "libaccel/packet/frustums_simd.h"

namespace accel {

namespace {

constexpr double kCostOfRuns = 1.1;          // of sorting by them, as a factor on the widths of frustums
constexpr std::uint32_t kComparedSize = 64;  // of packets, to compare orders by their frustums
// Trials: rays a way and time, and how much of a block they may take.
constexpr std::size_t kMostTried = 1024, kLeastTried = 256, kShareOfTrials = 24;
constexpr double kClearlyLess = 0.85;   // than the time of the way so far; a few rays make narrower packets than a block does
constexpr std::size_t kOrdered = 8192;  // rays that orders are compared on: some rows of a picture
constexpr std::uint16_t kMostBlocksPerTrial = 64;
constexpr std::uint8_t kRun = StreamPlan{}.run;

// Seconds that the calling thread has worked, which others on the machine do not add to.
double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

bool are_alike(const Ray& a, const Ray& b) {
  const auto dot = [](Vec3 v, Vec3 w) {
    return static_cast<double>(v.x) * w.x + static_cast<double>(v.y) * w.y + static_cast<double>(v.z) * w.z;
  };
  const double ab = dot(a.dir, b.dir);
  return ab > 0 && ab * ab > 0.9 * dot(a.dir, a.dir) * dot(b.dir, b.dir);
}

// Empty if the root is no node.
Aabb bounds_of(const Bvh8View& view) { return is_leaf(view.root) ? Aabb() : bounds_of_children(view.nodes[view.root]); }

}  // namespace

bool are_alike(std::span<const Ray> rays) {
  const std::size_t stride = rays.size() / 64 + 1;
  int alike = 0;
  for (std::size_t i = 1; i < rays.size(); i += stride) alike += are_alike(rays[i - 1], rays[i]) ? 1 : -1;
  return alike >= 0;
}

template <class Answer>
Bvh8StreamTracer<Answer>::Bvh8StreamTracer(const Bvh8View& view, const PacketOptions& options, std::atomic<StreamPlan>& plan)
    : view_(view), options_(options), bounds_(bounds_of(view)), plan_(plan), order_(bounds_, options.cell_fraction) {
  options_.max_size = std::clamp(options.max_size, 1u, kMaxPacketSize);
  options_.block_size = std::max(options.block_size, 1u);
}

template <class Answer>
void Bvh8StreamTracer<Answer>::trace(std::span<const Ray> rays, std::span<Answer> answers) {
  if (is_leaf(view_.root)) return trace_by_turns(rays, answers);
  for (std::size_t first = 0, n; first < rays.size(); first += n) {
    n = std::min<std::size_t>(rays.size() - first, options_.block_size);
    const auto block = rays.subspan(first, n);
    const auto block_answers = answers.subspan(first, n);
    if (are_alike(block))
      trace_alike(block, block_answers);
    else
      trace_by_turns(block, block_answers);
  }
}

template <class Answer>
void Bvh8StreamTracer<Answer>::trace_alike(std::span<const Ray> rays, std::span<Answer> answers) {
  StreamPlan plan = plan_.load(std::memory_order_relaxed);
  std::size_t tried = 0;
  if (plan.blocks_to_trial == 0 && rays.size() >= kShareOfTrials * kLeastTried) {
    const Way before = plan.way;
    tried = try_ways(rays, answers, plan);
    plan.trial_distance = plan.way == before ? std::min<std::uint16_t>(2 * plan.trial_distance, kMostBlocksPerTrial) : 1;
    plan.blocks_to_trial = plan.trial_distance;
  }
  plan.blocks_to_trial -= plan.blocks_to_trial > 0 ? 1 : 0;
  plan_.store(plan, std::memory_order_relaxed);
  trace_in(plan.way, plan.run, rays.subspan(tried), answers.subspan(tried));
}

template <class Answer>
std::size_t Bvh8StreamTracer<Answer>::try_ways(std::span<const Ray> rays, std::span<Answer> answers, StreamPlan& plan) {
  // The first trial decides; what confirms it may be short.
  const std::size_t most = plan.trial_distance > 1 ? kLeastTried : kMostTried;
  const std::size_t size = std::clamp(rays.size() / kShareOfTrials, kLeastTried, most);
  order_.begin(rays.first(std::min(rays.size(), kOrdered)));
  const double in_runs = make_packets(rays, kRun, kComparedSize), as_they_come = make_packets(rays, 0, kComparedSize);
  plan.run = in_runs * kCostOfRuns < as_they_come ? kRun : 0;

  // Twice each, for what is traced first finds the caches cold.
  std::array<double, kWays> least;
  least.fill(std::numeric_limits<double>::infinity());
  std::size_t tried = 0;
  for (int time = 0; time < 2; ++time)
    for (std::size_t w = 0; w < kWays; ++w, tried += size) {
      const double begin = thread_seconds();
      trace_in(static_cast<Way>(w), plan.run, rays.subspan(tried, size), answers.subspan(tried, size));
      least[w] = std::min(least[w], thread_seconds() - begin);
    }
  const auto best = std::min_element(least.begin(), least.end());
  if (*best < kClearlyLess * least[static_cast<std::size_t>(plan.way)]) plan.way = static_cast<Way>(best - least.begin());
  return tried;
}

template <class Answer>
void Bvh8StreamTracer<Answer>::trace_in(Way way, std::uint32_t run, std::span<const Ray> rays, std::span<Answer> answers) {
  if (way == Way::turns || rays.empty()) return trace_by_turns(rays, answers);
  order_.begin(rays);
  make_packets(rays, run, options_.max_size);
  LocalizedBatch batch = packets_.batch({}, rays.data(), order_.ids().data());
  batch.frustums = packets_.frustums().data();
  if constexpr (kIsAnyHit)
    trace_bvh8_packets_simd(view_, batch, answers.data(), way == Way::packets_from_far_end);
  else
    trace_bvh8_packets_simd(view_, batch, answers.data());
  trace_left(rays, answers);
}

template <class Answer>
double Bvh8StreamTracer<Answer>::make_packets(std::span<const Ray> rays, std::uint32_t run, std::uint32_t size) {
  order_.sort(run);
  const std::uint8_t* const faces = order_.faces().data();
  packets_.cut(faces, faces, order_.faces().size(), size, std::min(options_.min_size, size));
  make_frustums_simd(packets_.batch({}, rays.data(), order_.ids().data()), faces, bounds_, packets_.frustums().data());
  double width = 0;
  for (std::size_t i = 0; i < packets_.count(); ++i)
    width += static_cast<double>(packets_.size_of(i)) * packets_.frustums()[i].width();
  return width;
}

template <class Answer>
void Bvh8StreamTracer<Answer>::trace_left(std::span<const Ray> rays, std::span<Answer> answers) {
  left_.clear(), rays_left_.clear();
  packets_.for_each_left([&](std::uint32_t first, std::uint32_t end) {
    for (std::uint32_t i = first; i < end; ++i) left_.push_back(order_.ids()[i]);
  });
  for (const std::uint32_t id : left_) rays_left_.push_back(rays[id]);
  answers_left_.resize(left_.size());
  trace_by_turns(rays_left_, answers_left_);
  for (std::size_t i = 0; i < left_.size(); ++i) answers[left_[i]] = answers_left_[i];
}

template class Bvh8StreamTracer<Hit>;
template class Bvh8StreamTracer<std::uint8_t>;

}  // namespace accel
