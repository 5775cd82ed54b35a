#include "libaccel/packet/bvh8_stream.h"

#include <algorithm>
#include <limits>

#include "libaccel/packet/frustums_simd.h"

namespace accel {

namespace {

// Batches of fewer rays are not worth the preparation of packets.
constexpr std::size_t kFewestInPackets = 256;
constexpr std::uint32_t kRun = 8;              // of rays that are sorted as one
constexpr double kCostOfRuns = 1.1;            // of sorting by them, as a factor on the widths of frustums
constexpr std::uint32_t kComparedSize = 64;    // of packets, to compare orders by their frustums
constexpr std::uint32_t kBlocksPerTrial = 16;  // of an order, or of packets where they were of little use
constexpr std::uint32_t kTrialSize = 2048;
// Packets of scenes where they pay have 8 to 13 rays in a group's step; those of small triangles, where they do not, 4.
constexpr std::uint64_t kLeastRaysInStep = 6;

bool are_alike(const Ray& a, const Ray& b) {
  const auto dot = [](Vec3 v, Vec3 w) {
    return static_cast<double>(v.x) * w.x + static_cast<double>(v.y) * w.y + static_cast<double>(v.z) * w.z;
  };
  const double ab = dot(a.dir, b.dir);
  return ab > 0 && ab * ab > 0.9 * dot(a.dir, a.dir) * dot(b.dir, b.dir);
}

// Empty if the root is no node.
Aabb bounds_of(const Bvh8View& view) {
  Aabb bounds;
  if (is_leaf(view.root)) return bounds;
  const Bvh8Node& root = view.nodes[view.root];
  for (std::uint32_t c = 0; c < kBvh8Arity; ++c)
    if (root.child[c] != kNoNode) bounds.extend(root.bounds(c));
  return bounds;
}

}  // namespace

bool are_alike(std::span<const Ray> rays) {
  const std::size_t stride = rays.size() / 64 + 1;
  int alike = 0;
  for (std::size_t i = 1; i < rays.size(); i += stride) alike += are_alike(rays[i - 1], rays[i]) ? 1 : -1;
  return alike >= 0;
}

template <class Answer>
Bvh8StreamTracer<Answer>::Bvh8StreamTracer(const Bvh8View& view, const PacketOptions& options)
    : view_(view), options_(options), bounds_(bounds_of(view)), order_(bounds_, options.cell_fraction) {
  options_.max_size = std::clamp(options.max_size, 1u, kMaxPacketSize);
  options_.block_size = std::max(options.block_size, 1u);
}

template <class Answer>
void Bvh8StreamTracer<Answer>::trace(std::span<const Ray> rays, std::span<Answer> answers) {
  if (rays.size() < kFewestInPackets || is_leaf(view_.root)) return trace_by_turns(rays, answers);
  for (std::size_t first = 0, n; first < rays.size(); first += n) {
    const bool is_trial = blocks_by_turns_ == 0 && !packets_pay_;
    n = std::min<std::size_t>(rays.size() - first, is_trial ? std::min(kTrialSize, options_.block_size) : options_.block_size);
    const auto block = rays.subspan(first, n);
    if (blocks_by_turns_ == 0 && are_alike(block)) {
      packets_pay_ = trace_packets(block, answers.subspan(first, n));
      if (!packets_pay_) blocks_by_turns_ = kBlocksPerTrial;
    } else {
      blocks_by_turns_ -= blocks_by_turns_ > 0 ? 1 : 0;
      trace_by_turns(block, answers.subspan(first, n));
    }
  }
}

template <class Answer>
bool Bvh8StreamTracer<Answer>::trace_packets(std::span<const Ray> rays, std::span<Answer> answers) {
  order_.begin(rays);
  if (blocks_to_trial_-- == 0) {
    const double in_runs = make_packets(rays, kRun, kComparedSize), as_they_come = make_packets(rays, 0, kComparedSize);
    run_ = in_runs * kCostOfRuns < as_they_come ? kRun : 0;
    blocks_to_trial_ = kBlocksPerTrial;
  }
  make_packets(rays, run_, options_.max_size);
  LocalizedBatch batch = packets_.batch({}, rays.data(), order_.ids().data());
  batch.frustums = packets_.frustums().data();
  const GroupWork work = trace_bvh8_packets_simd(view_, batch, answers.data());
  trace_left(rays, answers);
  return work.rays >= kLeastRaysInStep * work.nodes;
}

template <class Answer>
double Bvh8StreamTracer<Answer>::make_packets(std::span<const Ray> rays, std::uint32_t run, std::uint32_t size) {
  order_.sort(run);
  const std::uint8_t* const faces = order_.faces().data();
  packets_.cut(faces, faces, rays.size(), size, std::min(options_.min_size, size));
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
