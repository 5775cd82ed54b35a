#include "libaccel/packet/bvh8_stream.h"

#include <time.h>

#include <algorithm>
#include <array>
#include <limits>

#include "libaccel/packet/frustums_simd.h"

namespace accel {

namespace {

constexpr std::size_t kOrdered = 8192;  // rays that orders are compared on: some rows of a picture
// Trials: places in a block where a packet is traced in each way, and how much of a block they may take.
constexpr std::size_t kPlaces = 4, kShareOfTrials = 4;
constexpr double kClearlyLess = 0.85;  // than the time of another way
constexpr double kHopeless = 3;        // times that of the fastest way: after two places, not tried again
constexpr std::uint16_t kGrowthOfDistance = 4, kMostBlocksPerTrial = 64;
constexpr std::uint8_t kRun = 8;  // rays that are sorted as one, until orders have been compared

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

template <class View, class Answer>
Bvh8StreamTracer<View, Answer>::Bvh8StreamTracer(const View& view, const PacketOptions& options, std::atomic<StreamPlan>& plan)
    : view_(view), options_(options), bounds_(bounds_of(view)), plan_(plan), order_(bounds_, options.cell_fraction) {
  options_.max_size = std::clamp(options.max_size, 1u, kMaxPacketSize);
  options_.block_size = std::max(options.block_size, 1u);
}

template <class View, class Answer>
void Bvh8StreamTracer<View, Answer>::trace(std::span<const Ray> rays, std::span<Answer> answers) {
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

template <class View, class Answer>
void Bvh8StreamTracer<View, Answer>::trace_alike(std::span<const Ray> rays, std::span<Answer> answers) {
  StreamPlan plan = plan_.load(std::memory_order_relaxed);
  const bool is_trial = plan.blocks_to_trial == 0 && rays.size() >= kOrdered;
  plan.blocks_to_trial -= plan.blocks_to_trial > 0 ? 1 : 0;
  if (plan.way == Way::turns && !is_trial) {
    plan_.store(plan, std::memory_order_relaxed);
    return trace_by_turns(rays, answers);
  }
  if (is_trial && plan.run == StreamPlan::kNotCompared) plan.run = better_run(rays);
  order_.begin(rays);
  make_packets(plan.run == StreamPlan::kNotCompared ? kRun : plan.run, options_.max_size);
  const std::size_t places = is_trial && packets_.count() >= kShareOfTrials * kPlaces * kWays ? kPlaces : 0;
  if (places > 0) try_ways(rays, answers, plan);
  plan_.store(plan, std::memory_order_relaxed);
  std::size_t next = 0;
  for (std::size_t place = 0; place < places; ++place) {
    trace_packets(plan.way, next, first_of(place), rays, answers);
    next = first_of(place) + kWays;
  }
  trace_packets(plan.way, next, packets_.count(), rays, answers);
  begin_gathering();
  packets_.for_each_left([&](std::uint32_t first, std::uint32_t end) { gather(first, end); });
  trace_gathered(rays, answers);
}

template <class View, class Answer>
std::uint8_t Bvh8StreamTracer<View, Answer>::better_run(std::span<const Ray> rays) {
  const auto some = rays.first(kOrdered);
  order_.begin(some);
  const double in_runs = width_in_runs(some, kRun), as_they_come = width_in_runs(some, 0);
  return in_runs * kCostOfRuns < as_they_come ? kRun : 0;
}

template <class View, class Answer>
double Bvh8StreamTracer<View, Answer>::width_in_runs(std::span<const Ray> rays, std::uint32_t run) {
  make_packets(run, kComparedSize);
  make_frustums_simd(packets_.batch({}, rays.data(), order_.ids().data()), order_.faces().data(), bounds_,
                     packets_.frustums().data());
  double width = 0;
  for (std::size_t i = 0; i < packets_.count(); ++i)
    width += static_cast<double>(packets_.size_of(i)) * packets_.frustums()[i].width();
  return width;
}

template <class View, class Answer>
std::size_t Bvh8StreamTracer<View, Answer>::first_of(std::size_t place) const {
  return (2 * place + 1) * packets_.count() / (2 * kPlaces);
}

template <class View, class Answer>
void Bvh8StreamTracer<View, Answer>::try_ways(std::span<const Ray> rays, std::span<Answer> answers, StreamPlan& plan) {
  std::array<double, kWays> seconds{}, count{};
  const auto cost = [&](std::size_t way) { return seconds[way] / count[way]; };
  const auto fastest = [&] {
    std::size_t best = 0;
    for (std::size_t way = 1; way < kWays; ++way) best = cost(way) < cost(best) ? way : best;
    return best;
  };
  for (std::size_t place = 0; place < kPlaces; ++place)
    for (std::size_t i = 0; i < kWays; ++i) {
      const std::size_t packet = first_of(place) + i;
      std::size_t way = (place + i) % kWays;
      if (place > 1 && cost(way) > kHopeless * cost(fastest())) way = fastest();
      const double begin = thread_seconds();
      trace_packets(static_cast<Way>(way), packet, packet + 1, rays, answers);
      seconds[way] += thread_seconds() - begin, count[way] += static_cast<double>(packets_.size_of(packet));
    }
  const std::size_t best = fastest(), before = static_cast<std::size_t>(plan.way);
  if (cost(best) < kClearlyLess * cost(before)) plan.way = static_cast<Way>(best);
  // Turns and packets differ most, so that it must not be chance which of them the next blocks go in.
  const double turns = cost(0), packets = std::min(cost(1), cost(kWays - 1));
  const bool is_clear = turns < kClearlyLess * packets || packets < kClearlyLess * turns;
  plan.trial_distance = static_cast<std::size_t>(plan.way) == before && is_clear
                            ? std::min<std::uint16_t>(kGrowthOfDistance * plan.trial_distance, kMostBlocksPerTrial)
                            : 1;
  plan.blocks_to_trial = plan.trial_distance - 1u;
}

template <class View, class Answer>
void Bvh8StreamTracer<View, Answer>::trace_packets(Way way, std::size_t first, std::size_t end, std::span<const Ray> rays,
                                                   std::span<Answer> answers) {
  LocalizedBatch batch = packets_.batch({}, rays.data(), order_.ids().data());
  batch.active += first, batch.count = end - first;
  if (way == Way::turns) {
    begin_gathering();
    for (std::size_t i = 0; i < batch.count; ++i) gather(batch.packets[batch.active[i]], batch.packets[batch.active[i] + 1]);
    trace_gathered(rays, answers);
  } else if constexpr (kIsAnyHit) {
    trace_bvh8_packets_simd(view_, batch, order_.faces().data(), answers.data(), way == Way::packets_from_far_end);
  } else {
    trace_bvh8_packets_simd(view_, batch, order_.faces().data(), answers.data());
  }
}

template <class View, class Answer>
void Bvh8StreamTracer<View, Answer>::make_packets(std::uint32_t run, std::uint32_t size) {
  order_.sort(run);
  packets_.cut_by_face(order_.faces(), size, std::min(options_.min_size, size));
}

template <class View, class Answer>
void Bvh8StreamTracer<View, Answer>::trace_gathered(std::span<const Ray> rays, std::span<Answer> answers) {
  gathered_rays_.clear();
  for (const std::uint32_t id : gathered_) gathered_rays_.push_back(rays[id]);
  gathered_answers_.resize(gathered_.size());
  trace_by_turns(gathered_rays_, gathered_answers_);
  for (std::size_t i = 0; i < gathered_.size(); ++i) answers[gathered_[i]] = gathered_answers_[i];
}

template class Bvh8StreamTracer<Bvh8View, Hit>;
template class Bvh8StreamTracer<Bvh8View, std::uint8_t>;
template class Bvh8StreamTracer<TwoLevelBvh8View, Hit>;
template class Bvh8StreamTracer<TwoLevelBvh8View, std::uint8_t>;

}  // namespace accel
