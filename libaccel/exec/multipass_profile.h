// The kernels, options and figures of the multipass executor: a batch of rays as streams through six kernels. See
// exec/multipass.h.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <type_traits>

namespace accel {

// The kernels of Foley and Sugerman 2005, section 3.3, in the order of their data flow (Fig. 7). The flow is a cycle from down
// to up; initialize feeds it.
enum class MultipassKernel : std::uint8_t { initialize, down, leaf, intersect, continue_search, up, finished };
inline constexpr int kMultipassKernels = 6;  // finished is none: the ray needs no more

constexpr const char* kernel_name(MultipassKernel kernel) {
  constexpr const char* kNames[kMultipassKernels + 1] = {"initialize", "down", "leaf",    "intersect",
                                                         "continue",   "up",   "finished"};
  return kNames[static_cast<int>(kernel)];
}

template <MultipassKernel kKernel>
using MultipassKernelConstant = std::integral_constant<MultipassKernel, kKernel>;

// Calls visit(MultipassKernelConstant<kernel>()): code that is compiled for each kernel, chosen at run time. `finished` is
// none.
template <class Visit>
void visit_kernel(MultipassKernel kernel, const Visit& visit) {
  using Kernel = MultipassKernel;
  switch (kernel) {
    case Kernel::initialize:
      return visit(MultipassKernelConstant<Kernel::initialize>());
    case Kernel::down:
      return visit(MultipassKernelConstant<Kernel::down>());
    case Kernel::leaf:
      return visit(MultipassKernelConstant<Kernel::leaf>());
    case Kernel::intersect:
      return visit(MultipassKernelConstant<Kernel::intersect>());
    case Kernel::continue_search:
      return visit(MultipassKernelConstant<Kernel::continue_search>());
    case Kernel::up:
      return visit(MultipassKernelConstant<Kernel::up>());
    case Kernel::finished:
      return;
  }
}

// Which kernel runs next.
//   delany         [FS05] section 3.4: run a kernel until more than twice as many rays wait for the next one as for it
//   largest_first  the kernel that most rays wait for
//   drain          run a kernel until no ray waits for it
enum class MultipassRule : std::uint8_t { delany, largest_first, drain };
inline constexpr int kMultipassRules = 3;

constexpr const char* rule_name(MultipassRule rule) {
  constexpr const char* kNames[kMultipassRules] = {"delany", "largest-first", "drain"};
  return kNames[static_cast<int>(rule)];
}

struct MultipassOptions {
  MultipassRule rule = MultipassRule::delany;

  // Rays in flight, the paper's 512 x 512 by default. Memory is theirs only: bytes_in_flight of the profile.
  std::uint32_t batch_size = 1u << 18;

  // Off: a pass runs over all rays of the batch and masks those that are elsewhere, as the paper does with the z-buffer. On: it
  // runs over a list of those that wait for it. Passes and hits are the same.
  bool compact = false;
};

// How many rays wait for each kernel.
class MultipassCounts {
 public:
  std::uint32_t& operator[](MultipassKernel kernel) { return counts_[static_cast<std::size_t>(kernel)]; }
  std::uint32_t operator[](MultipassKernel kernel) const { return counts_[static_cast<std::size_t>(kernel)]; }
  std::uint64_t total() const { return std::accumulate(counts_.begin(), counts_.end(), std::uint64_t{0}); }

 private:
  std::array<std::uint32_t, kMultipassKernels> counts_{};
};

// Sums over all batches.
struct MultipassProfile {
  std::uint64_t rays = 0;
  std::uint64_t batches = 0;
  std::uint64_t switches = 0;         // passes that run another kernel than the pass before
  std::uint64_t bytes_in_flight = 0;  // of the largest batch: states, hits, stacks, and what says where each ray is

  struct KernelPasses {
    std::uint64_t passes = 0;
    std::uint64_t rays = 0;   // that the passes worked on
    std::uint64_t width = 0;  // rays that the passes ran over, at work or not
    std::uint64_t warps = 0;  // groups of 32 neighbours among these with any ray at work: what a machine cannot cull

    // What the rays carry from pass to pass: the ray and the state and hit of its traversal, whole, and entries of its stack.
    std::uint64_t bytes_read = 0, bytes_written = 0;
    std::uint64_t bytes_fetched = 0;   // from the structure
    std::uint64_t bytes_schedule = 0;  // to know which rays are at work: tags looked at and set, or lists read and written

    std::uint64_t bytes_recirculated() const { return bytes_read + bytes_written; }
    double utilisation() const { return width == 0 ? 1.0 : static_cast<double>(rays) / static_cast<double>(width); }
    double warp_utilisation() const {
      return warps == 0 ? 1.0 : static_cast<double>(rays) / (32.0 * static_cast<double>(warps));
    }
    double rays_per_pass() const { return passes == 0 ? 0.0 : static_cast<double>(rays) / static_cast<double>(passes); }

    KernelPasses& operator+=(const KernelPasses& other) {
      passes += other.passes, rays += other.rays, width += other.width, warps += other.warps;
      bytes_read += other.bytes_read, bytes_written += other.bytes_written;
      bytes_fetched += other.bytes_fetched, bytes_schedule += other.bytes_schedule;
      return *this;
    }
  };
  std::array<KernelPasses, kMultipassKernels> kernels{};

  KernelPasses& of(MultipassKernel kernel) { return kernels[static_cast<std::size_t>(kernel)]; }
  const KernelPasses& of(MultipassKernel kernel) const { return kernels[static_cast<std::size_t>(kernel)]; }

  // Over all kernels.
  KernelPasses total() const {
    return std::accumulate(kernels.begin(), kernels.end(), KernelPasses{},
                           [](KernelPasses a, const KernelPasses& b) { return a += b; });
  }
  // What [FS05] Table 2 calls transitions: Leaf and Continue together.
  std::uint64_t transitions() const { return of(MultipassKernel::leaf).rays + of(MultipassKernel::continue_search).rays; }

  MultipassProfile& operator+=(const MultipassProfile& other) {
    rays += other.rays, batches += other.batches, switches += other.switches;
    bytes_in_flight = bytes_in_flight < other.bytes_in_flight ? other.bytes_in_flight : bytes_in_flight;
    for (std::size_t k = 0; k < kernels.size(); ++k) kernels[k] += other.kernels[k];
    return *this;
  }
};

}  // namespace accel
