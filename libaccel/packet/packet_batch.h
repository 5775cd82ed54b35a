// Batches of rays as packets, stage by stage over the whole batch: the pipeline of Garanzha and Loop 2010 [GL10] as it runs on
// devices, where a batch has millions of rays. packet/packet_tracer.h is its twin for the caches of CPUs.
//
//   order_rays         values of packet/ray_hash.h, sorted by packet/csd_sort.h                    [GL10] section 3.1
//   make_packets       packet/packet_ranges.h                                                       section 3.1, Fig. 6
//   make_frustums      packet/frustum.h                                                             section 3.2
//   find_leaves        packet/breadth_first.h; then the frustums that meet anything                 section 3.3
//   list_tasks         the rays of these frustums, for packet/localized_warp.h                      section 3.4
//   find_other_rays    those of small packets, those without a frustum and those whose frustum gave up
//
// Deviations. The face comes first among the bits of the values, so that packets go on where a cell ends. Rays that packets do
// not serve are traced one by one: nothing is dropped, and hits are those of single rays.
//
// It is written in primitives (packet/cpu_primitives.h), so that the CPU tests what devices run. Memory: about 60 bytes a ray
// of a block, and up to 90 more where frustums use their whole budget.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "libaccel/packet/breadth_first.h"
#include "libaccel/packet/csd_sort.h"
#include "libaccel/packet/localized_warp.h"
#include "libaccel/packet/packet_options.h"
#include "libaccel/packet/packet_ranges.h"
#include "libaccel/packet/ray_hash.h"

namespace accel {

// The values that rays are sorted by: the face, which tells rays without one, too, then what the hash has but for its own face.
struct PacketKey {
  using Hash = RayHash<std::uint64_t, kFineDirectionBits>;
  static constexpr int kWithinBits = 2 * Hash::kDirectionBits, kFaceShift = 3 * Hash::kOriginBits + kWithinBits;
  static_assert(kFaceShift + 3 <= 64);

  Hash hash;

  ACCEL_HD std::uint64_t operator()(const Ray& ray) const {
    const std::uint64_t value = hash(ray), within = value & ((std::uint64_t{1} << kWithinBits) - 1);
    const std::uint64_t cell = value >> (kWithinBits + 3);
    return static_cast<std::uint64_t>(face_of(ray)) << kFaceShift | cell << kWithinBits | within;
  }
  ACCEL_HD static std::uint8_t face(std::uint64_t key) { return static_cast<std::uint8_t>(key >> kFaceShift); }
};

// The rays of a packet, for make_frustum().
struct RaysByIds {
  const Ray* rays;
  const std::uint32_t* ids;

  ACCEL_HD Ray operator()(std::uint32_t i) const { return rays[ids[i]]; }
};

// One block of rays. All is public that CUDA's lambdas are in or work on.
template <class Primitives>
class PacketBatch {
 public:
  template <class T>
  using Array = typename Primitives::template Array<T>;

  // Rays that are to be traced one by one.
  struct OtherRays {
    Array<std::uint32_t> ids;
    Array<Ray> rays;  // rays[i] is ray ids[i] of the block
    std::size_t count = 0;
  };

  PacketBatch(const Bvh2View& view, const PacketOptions& options);

  // Up to the tasks, of n < 2^32 rays, which stay where they are until the batch is done with. view.octo_count > 0.
  void prepare(const Ray* rays, std::size_t n);

  // The rays of packets whose frustums meet anything. Rays that are in no task, and none of the others, are misses.
  LocalizedTasks tasks() const;
  OtherRays find_other_rays() const;

  // The stages.
  void order_rays();
  void make_packets();
  void make_frustums();
  void find_leaves();
  void list_tasks();

 private:
  Bvh2View view_;
  PacketOptions options_;
  PacketKey key_;
  float widest_;  // of a frustum
  const Ray* rays_ = nullptr;
  std::size_t n_ = 0;

  Array<std::uint32_t> ids_;   // the order of rays
  Array<std::uint8_t> faces_;  // in that order
  PacketRanges<Primitives> ranges_;
  Array<std::uint32_t> packets_, budgets_;  // of the frustums
  Array<Frustum> frustums_;
  std::size_t frustum_count_ = 0;
  Array<std::uint8_t> gave_up_;
  BreadthFirst<Primitives> traversal_;
  const FrustumQueue<Primitives>* leaves_ = nullptr;

  // Frustums that meet anything, by number.
  Array<std::uint32_t> active_packets_, firsts_;  // see LocalizedBatch
  std::size_t active_count_ = 0;
  Array<LocalizedTask> tasks_;
  std::size_t task_count_ = 0;
};

template <class Primitives>
PacketBatch<Primitives>::PacketBatch(const Bvh2View& view, const PacketOptions& options)
    : view_(view), options_(options), key_{PacketKey::Hash::make(view.bounds, options.cell_fraction)} {
  options_.max_size = std::clamp(options.max_size, 1u, kMaxPacketSize);
  const Vec3 e = view.bounds.extent();
  widest_ = options.max_width * max_of(max_of(e.x, e.y), e.z);
}

template <class Primitives>
void PacketBatch<Primitives>::prepare(const Ray* rays, std::size_t n) {
  rays_ = rays, n_ = n;
  order_rays();
  make_packets();
  make_frustums();
  find_leaves();
  list_tasks();
}

template <class Primitives>
void PacketBatch<Primitives>::order_rays() {
  Array<std::uint64_t> keys(n_);
  faces_ = Array<std::uint8_t>(n_);
  std::uint64_t* const key = keys.data();
  const Ray* const rays = rays_;
  const PacketKey key_of = key_;
  Primitives::for_each(n_, [=] ACCEL_HD_LAMBDA(std::size_t i) { key[i] = key_of(rays[i]); });
  ids_ = std::move(csd_sort<Primitives>(std::as_const(keys).data(), n_).ids);
  const std::uint32_t* const ids = ids_.data();
  std::uint8_t* const faces = faces_.data();
  Primitives::for_each(n_, [=] ACCEL_HD_LAMBDA(std::size_t i) { faces[i] = PacketKey::face(key[ids[i]]); });
}

// Packets, and which of them get a frustum.
template <class Primitives>
void PacketBatch<Primitives>::make_packets() {
  ranges_ = packet_ranges<Primitives>(std::as_const(faces_).data(), n_, options_.max_size);
  Array<std::uint8_t> flags(ranges_.count);
  packets_ = Array<std::uint32_t>(ranges_.count);
  std::uint8_t* const has_frustum = flags.data();
  const std::uint32_t* const base = ranges_.base.data();
  const std::uint8_t* const faces = faces_.data();
  const std::uint32_t min_size = options_.min_size;
  Primitives::for_each(ranges_.count, [=] ACCEL_HD_LAMBDA(std::size_t p) {
    has_frustum[p] = base[p + 1] - base[p] >= min_size && faces[base[p]] != kNoFace ? 1 : 0;
  });
  frustum_count_ = Primitives::compact(has_frustum, ranges_.count, packets_.data());
}

template <class Primitives>
void PacketBatch<Primitives>::make_frustums() {
  frustums_ = Array<Frustum>(frustum_count_), budgets_ = Array<std::uint32_t>(frustum_count_);
  Frustum* const frustums = frustums_.data();
  std::uint32_t* const budgets = budgets_.data();
  const std::uint32_t *const packets = packets_.data(), *const base = ranges_.base.data(), *const ids = ids_.data();
  const std::uint8_t* const faces = faces_.data();
  const Ray* const rays = rays_;
  const Aabb bounds = view_.bounds;
  const float widest = widest_;
  const float budget = options_.budget;
  Primitives::for_each(frustum_count_, [=] ACCEL_HD_LAMBDA(std::size_t f) {
    const std::uint32_t first = base[packets[f]], size = base[packets[f] + 1] - first;
    frustums[f] = make_frustum(faces[first], size, RaysByIds{rays, ids + first}, bounds);
    // Frustums that are too wide to begin with give up at once.
    budgets[f] = frustums[f].width() <= widest ? budget_for(budget, size) : 0;
  });
}

// [GL10], section 3.3, and at its end the frustums that meet anything.
template <class Primitives>
void PacketBatch<Primitives>::find_leaves() {
  gave_up_ = Array<std::uint8_t>(frustum_count_);
  leaves_ = &traversal_.run(view_, frustums_.data(), frustum_count_, budgets_.data(), gave_up_.data());
  auto active = detail::compress<Primitives>(leaves_->frustum.data(), leaves_->count);
  active_count_ = active.count;
  firsts_ = Array<std::uint32_t>(active_count_ + 1), active_packets_ = std::move(active.hash);
  std::uint32_t *const firsts = firsts_.data(), *const active_packets = active_packets_.data();
  const std::uint32_t *const base = active.base.data(), *const packets = packets_.data();
  const std::size_t count = active_count_;
  const auto end = static_cast<std::uint32_t>(leaves_->count);
  Primitives::for_each(count + 1, [=] ACCEL_HD_LAMBDA(std::size_t a) {
    firsts[a] = a < count ? base[a] : end;
    if (a < count) active_packets[a] = packets[active_packets[a]];  // a frustum until now
  });
}

template <class Primitives>
void PacketBatch<Primitives>::list_tasks() {
  Array<std::uint32_t> sizes(active_count_);
  std::uint32_t* const first_tasks = sizes.data();
  const std::uint32_t *const active_packets = active_packets_.data(), *const base = ranges_.base.data(),
                             *const ids = ids_.data();
  Primitives::for_each(active_count_, [=] ACCEL_HD_LAMBDA(std::size_t a) {
    first_tasks[a] = base[active_packets[a] + 1] - base[active_packets[a]];
  });
  task_count_ = Primitives::exclusive_scan(first_tasks, active_count_, first_tasks);
  tasks_ = Array<LocalizedTask>(task_count_);
  LocalizedTask* const tasks = tasks_.data();
  Primitives::for_each(active_count_, [=] ACCEL_HD_LAMBDA(std::size_t a) {
    const std::uint32_t first = base[active_packets[a]], size = base[active_packets[a] + 1] - first;
    for (std::uint32_t i = 0; i < size; ++i) tasks[first_tasks[a] + i] = {ids[first + i], static_cast<std::uint32_t>(a)};
  });
}

template <class Primitives>
LocalizedTasks PacketBatch<Primitives>::tasks() const {
  return {.nodes = view_.octo,
          .leaves = view_.leaves,
          .rays = rays_,
          .tasks = tasks_.data(),
          .firsts = firsts_.data(),
          .places = leaves_->place.data(),
          .count = static_cast<std::uint32_t>(task_count_)};
}

template <class Primitives>
typename PacketBatch<Primitives>::OtherRays PacketBatch<Primitives>::find_other_rays() const {
  Array<std::uint8_t> by_packet(ranges_.count), by_ray(n_);
  std::uint8_t *const is_other = by_packet.data(), *const flags = by_ray.data();
  const std::uint8_t* const gave_up = gave_up_.data();
  const std::uint32_t *const packets = packets_.data(), *const base = ranges_.base.data(), *const ids = ids_.data();
  Primitives::for_each(ranges_.count, [=] ACCEL_HD_LAMBDA(std::size_t p) { is_other[p] = 1; });
  Primitives::for_each(frustum_count_, [=] ACCEL_HD_LAMBDA(std::size_t f) { is_other[packets[f]] = gave_up[f]; });
  Primitives::for_each(ranges_.count, [=] ACCEL_HD_LAMBDA(std::size_t p) {
    for (std::uint32_t at = base[p]; at < base[p + 1]; ++at) flags[at] = is_other[p];
  });

  OtherRays others;
  Array<std::uint32_t> places(n_);
  others.count = Primitives::compact(flags, n_, places.data());
  others.ids = Array<std::uint32_t>(others.count), others.rays = Array<Ray>(others.count);
  std::uint32_t* const other_ids = others.ids.data();
  Ray* const other_rays = others.rays.data();
  const std::uint32_t* const place = places.data();
  const Ray* const rays = rays_;
  Primitives::for_each(others.count, [=] ACCEL_HD_LAMBDA(std::size_t i) {
    other_ids[i] = ids[place[i]];
    other_rays[i] = rays[other_ids[i]];
  });
  return others;
}

// 0, 1, 2, ...
template <class Primitives>
typename Primitives::template Array<std::uint32_t> first_ids(std::size_t count) {
  typename Primitives::template Array<std::uint32_t> all(count);
  std::uint32_t* const ids = all.data();
  Primitives::for_each(count, [=] ACCEL_HD_LAMBDA(std::size_t i) { ids[i] = static_cast<std::uint32_t>(i); });
  return all;
}

template <class Primitives, class Answer>
void clear_answers(Answer* answers, std::size_t count) {
  Primitives::for_each(count, [=] ACCEL_HD_LAMBDA(std::size_t i) { answers[i] = Answer{}; });
}

// Localized intersection in primitives, a ray a thread.
template <class Primitives, class Test, Query kQuery>
struct IntersectByRay {
  template <class Answer>
  void operator()(const LocalizedTasks& all, Answer* answers) const {
    Primitives::for_each(all.count, [=] ACCEL_HD_LAMBDA(std::size_t i) {
      const LocalizedTask task = all.tasks[i];
      const std::uint32_t first = all.firsts[task.active], count = all.firsts[task.active + 1] - first;
      const Ray ray = all.rays[task.ray];
      NullObserver observer;
      const Hit hit = intersect_leaves<Test, kQuery>(all.nodes, all.leaves, ray, all.places + first, count, observer);
      store_answer(hit, answers[task.ray]);
    });
  }
};

// Answers all rays, block by block.
//   intersect(tasks, answers)                  answers the rays of the tasks
//   trace_singly(rays, ids, count, answers)    traces rays[0] to rays[count - 1] one by one; answers[ids[i]] answers rays[i]
template <class Primitives, class Answer, class Intersect, class TraceSingly>
void trace_packets(const Bvh2View& view, const PacketOptions& options, const Ray* rays, std::size_t n, Answer* answers,
                   const Intersect& intersect, const TraceSingly& trace_singly) {
  const std::size_t block_size = std::max(options.block_size, 1u);
  PacketBatch<Primitives> batch(view, options);
  for (std::size_t first = 0; first < n; first += block_size) {
    const std::size_t count = std::min(n - first, block_size);
    if (view.octo_count == 0) {
      // One leaf, or none.
      const auto ids = first_ids<Primitives>(count);
      trace_singly(rays + first, ids.data(), count, answers + first);
      continue;
    }
    batch.prepare(rays + first, count);
    clear_answers<Primitives>(answers + first, count);
    intersect(batch.tasks(), answers + first);
    const auto others = batch.find_other_rays();
    if (others.count > 0) trace_singly(others.rays.data(), others.ids.data(), others.count, answers + first);
  }
}

}  // namespace accel
