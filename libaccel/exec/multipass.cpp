#include "libaccel/exec/multipass.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "libaccel/core/buffer.h"
#include "libaccel/exec/cpu.h"
#include "libaccel/exec/multipass_schedule.h"
#include "libaccel/exec/multipass_step.h"

namespace accel {

namespace {

// The rays in flight.
class MultipassBatch {
 public:
  MultipassBatch(const AnyTraverser::View& view, const MultipassOptions& options, std::size_t capacity, int threads)
      : view_(view), options_(options), threads_(threads), states_(view, capacity), phases_(capacity), goes_to_(capacity) {
    if (!options.compact) return;
    spare_ = Buffer<std::uint32_t>(capacity);
    for (Buffer<std::uint32_t>& list : lists_) list = Buffer<std::uint32_t>(capacity);
  }

  // Traces as many rays as there is room for, or fewer. hits[i] answers rays[i].
  void run(std::span<const Ray> rays, std::span<Hit> hits) {
    rays_ = rays, hits_ = hits;
    const auto count = static_cast<std::uint32_t>(rays.size());
    std::fill_n(phases_.data(), count, Phase::done);
    std::fill_n(goes_to_.data(), count, MultipassKernel::initialize);
    if (options_.compact) std::iota(lists_[0].data(), lists_[0].data() + count, 0u);
    last_kernel_ = MultipassKernel::finished;
    // Passes cannot fail here.
    (void)run_passes(options_.rule, count, [this](MultipassKernel kernel, MultipassCounts& waiting) -> Status {
      run_pass(kernel, waiting);
      return Done{};
    });
    profile_.rays += count;
    profile_.batches += 1;
  }

  MultipassProfile profile() const {
    MultipassProfile result = profile_;
    std::size_t bytes = states_.size_bytes() + phases_.size_bytes() + goes_to_.size_bytes() + phases_.size() * sizeof(Hit) +
                        spare_.size_bytes();
    for (const Buffer<std::uint32_t>& list : lists_) bytes += list.size_bytes();
    result.bytes_in_flight = bytes;
    return result;
  }

 private:
  // What a block of a pass adds up. Blocks are the same for any number of threads.
  struct Block {
    std::array<std::uint32_t, kMultipassKernels + 1> next{};  // rays, by where they go
    std::uint32_t rays = 0, warps = 0;
    std::uint32_t called = 0;    // rays for which the traverser was called
    std::uint32_t answered = 0;  // others that ended: they touch their hit only
    StepObserver observer;
  };

  void run_pass(MultipassKernel kernel, MultipassCounts& waiting) {
    const std::uint32_t width = options_.compact ? waiting[kernel] : static_cast<std::uint32_t>(rays_.size());
    blocks_.assign((width + kRaysPerTask - 1) / kRaysPerTask, Block{});
    for_each_task([&](std::size_t b) {
      const auto begin = static_cast<std::uint32_t>(b * kRaysPerTask);
      const auto end = static_cast<std::uint32_t>(std::min<std::size_t>(width, begin + kRaysPerTask));
      blocks_[b] = step_block(kernel, begin, end);
    });
    account(kernel, width);
    if (options_.compact) return move_lists(kernel, waiting);
    waiting[kernel] = 0;
    for (const Block& block : blocks_)
      for (int k = 0; k < kMultipassKernels; ++k) waiting[static_cast<MultipassKernel>(k)] += block.next[k];
  }

  template <class Task>
  void for_each_task(const Task& task) {
    const auto run = [&](std::size_t begin, std::size_t end) {
      for (std::size_t b = begin; b < end; ++b) task(b);
    };
    for_each_block(blocks_.size(), threads_, run, 1);
  }

  // Places [begin, end) of the pass: rays, or entries of the kernel's list. One loop for both keeps one copy of the steps.
  Block step_block(MultipassKernel kernel, std::uint32_t begin, std::uint32_t end) {
    const std::uint32_t* list = options_.compact ? lists_[static_cast<std::size_t>(kernel)].data() : nullptr;
    std::uint32_t last_warp = ~0u;
    Block block;
    for (std::uint32_t place = begin; place < end; ++place) {
      const std::uint32_t i = list != nullptr ? list[place] : place;
      if (goes_to_[i] != kernel) continue;
      step(kernel, i, block);
      block.warps += place / 32 != last_warp ? 1 : 0;
      last_warp = place / 32;
    }
    return block;
  }

  void step(MultipassKernel kernel, std::uint32_t i, Block& block) {
    const bool calls = calls_traverser(kernel, phases_[i]);
    const MultipassKernel next = step_with(kernel, i, block.observer);
    goes_to_[i] = next;
    ++block.rays;
    ++block.next[static_cast<std::size_t>(next)];
    block.called += calls ? 1 : 0;
    block.answered += !calls && next == MultipassKernel::finished ? 1 : 0;
  }

  MultipassKernel step_with(MultipassKernel kernel, std::uint32_t i, StepObserver& observer) {
    using Kernel = MultipassKernel;
    AnyTraverser::State state = states_[i];
    const MultipassRay<AnyTraverser> ray{rays_[i], state, hits_[i], phases_[i]};
    switch (kernel) {
      case Kernel::initialize:
        return multipass_step<Kernel::initialize, AnyTraverser>(view_, ray, observer);
      case Kernel::down:
        return multipass_step<Kernel::down, AnyTraverser>(view_, ray, observer);
      case Kernel::leaf:
        return multipass_step<Kernel::leaf, AnyTraverser>(view_, ray, observer);
      case Kernel::intersect:
        return multipass_step<Kernel::intersect, AnyTraverser>(view_, ray, observer);
      case Kernel::continue_search:
        return multipass_step<Kernel::continue_search, AnyTraverser>(view_, ray, observer);
      case Kernel::up:
        return multipass_step<Kernel::up, AnyTraverser>(view_, ray, observer);
      case Kernel::finished:
        break;
    }
    return Kernel::finished;
  }

  // Appends the rays of the pass to the lists of the kernels that they go to, in their order.
  void move_lists(MultipassKernel kernel, MultipassCounts& waiting) {
    waiting[kernel] = 0;  // rays that stay go to the spare list
    const auto spare_index = static_cast<std::size_t>(kernel);
    first_.resize(blocks_.size());
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      first_[b] = waiting;
      for (int k = 0; k < kMultipassKernels; ++k) waiting[static_cast<MultipassKernel>(k)] += blocks_[b].next[k];
    }
    for_each_task([&](std::size_t b) {
      std::size_t j = b * kRaysPerTask;
      MultipassCounts& ends = first_[b];
      for (std::uint32_t n = blocks_[b].rays; n > 0; --n, ++j) {
        const std::uint32_t i = lists_[spare_index][j];
        const MultipassKernel to = goes_to_[i];
        if (to == MultipassKernel::finished) continue;
        (to == kernel ? spare_ : lists_[static_cast<std::size_t>(to)])[ends[to]++] = i;
      }
    });
    std::swap(spare_, lists_[spare_index]);
  }

  void account(MultipassKernel kernel, std::uint32_t width) {
    MultipassProfile::KernelPasses& p = profile_.of(kernel);
    p.passes += 1;
    p.width += width;
    if (last_kernel_ != kernel) ++profile_.switches;
    last_kernel_ = kernel;
    const std::uint64_t carried = view_.state_bytes + sizeof(Hit);
    const std::uint64_t read = sizeof(Ray) + (kernel == MultipassKernel::initialize ? 0 : carried);
    for (const Block& block : blocks_) {
      p.rays += block.rays, p.warps += block.warps;
      p.bytes_read += block.called * read + block.answered * sizeof(Hit);
      p.bytes_written += block.called * carried + block.answered * sizeof(Hit);
      p.bytes_schedule += options_.compact ? block.rays * 2 * sizeof(std::uint32_t) : block.rays;
      // What a step moves apart from the ray, its state and its hit.
      for (int m = 0; m < kMemoryClasses; ++m) {
        const std::uint64_t stored = block.observer.bytes_stored[m], loaded = block.observer.counters.bytes[m] - stored;
        const bool recirculates = static_cast<Memory>(m) == Memory::stack;
        (recirculates ? p.bytes_read : p.bytes_fetched) += loaded;
        if (recirculates) p.bytes_written += stored;
      }
    }
    if (!options_.compact) p.bytes_schedule += width;
  }

  const AnyTraverser::View& view_;
  const MultipassOptions options_;
  const int threads_;
  std::span<const Ray> rays_;
  std::span<Hit> hits_;

  // By ray.
  AnyStates states_;
  Buffer<Phase> phases_;
  Buffer<MultipassKernel> goes_to_;

  // Compaction: the rays that wait for each kernel, as many as the counts say.
  std::array<Buffer<std::uint32_t>, kMultipassKernels> lists_;
  Buffer<std::uint32_t> spare_;

  // The pass at hand.
  std::vector<Block> blocks_;
  std::vector<MultipassCounts> first_;
  MultipassKernel last_kernel_ = MultipassKernel::finished;
  MultipassProfile profile_;
};

}  // namespace

MultipassProfile trace_multipass(const AnyTraverser::View& view, std::span<const Ray> rays, std::span<Hit> hits,
                                 const MultipassOptions& options, int threads) {
  ACCEL_ASSERT(hits.empty() || hits.size() == rays.size());
  constexpr std::uint32_t kMostRays = 1u << 31;  // ray numbers have 32 bits
  const std::size_t capacity = std::min<std::size_t>(rays.size(), std::clamp(options.batch_size, 1u, kMostRays));
  Buffer<Hit> own(hits.empty() ? capacity : 0);
  MultipassBatch batch(view, options, capacity, threads == 1 ? 1 : 0);
  const auto run = [&] {
    for (std::size_t begin = 0; begin < rays.size(); begin += capacity) {
      const std::size_t size = std::min(capacity, rays.size() - begin);
      batch.run(rays.subspan(begin, size), hits.empty() ? own.span().first(size) : hits.subspan(begin, size));
    }
  };
  if (threads <= 1) {
    run();
  } else {
    tbb::task_arena arena(arena_size(threads));
    arena.execute(run);
  }
  return batch.profile();
}

}  // namespace accel
