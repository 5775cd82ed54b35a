#include "libaccel/build/build_context.h"

#include <limits>

#include "libaccel/structure/grid.h"

namespace accel {

void ProgressMeter::advance(std::uint64_t amount) {
  const std::uint64_t done = done_.fetch_add(amount, std::memory_order_relaxed) + amount;
  if (!progress_) return;
  const std::unique_lock lock(mutex_, std::try_to_lock);
  if (!lock.owns_lock()) return;
  const auto now = std::chrono::steady_clock::now();
  if (now - last_ < std::chrono::milliseconds(100)) return;
  last_ = now;
  if (!progress_(phase_, total_ > 0 ? static_cast<double>(done) / static_cast<double>(total_) : 1.0)) stopped_ = true;
}

namespace {

Status validate_grid_options(const BuildOptions& options) {
  const auto& cells = options.grid_resolution;
  const bool automatic = cells[0] == 0 && cells[1] == 0 && cells[2] == 0;
  std::uint64_t product = 1;
  for (const int n : cells) {
    if (!automatic && (n < 1 || n > kMaxGridResolution))
      return Error{"build option grid_resolution has " + std::to_string(n) + " cells along an axis; it must have 1 to " +
                   std::to_string(kMaxGridResolution) + " along each, or 0 along all"};
    product *= static_cast<std::uint64_t>(n);
  }
  if (product > kMaxGridCells)
    return Error{"build option grid_resolution makes " + std::to_string(product) + " cells; the most is " +
                 std::to_string(kMaxGridCells)};
  if (!(options.grid_density >= 0.0f && options.grid_density <= kMaxGridDensity))
    return Error{"build option grid_density must lie in [0, 1e6]"};
  return Done{};
}

}  // namespace

Status validate(const BuildOptions& options) {
  const auto is_cost = [](float x) { return x >= 0.0f && x <= 1e6f; };
  if (options.threads < 0)
    return Error{"build option threads is " + std::to_string(options.threads) + "; it must be 0 or more"};
  if (!is_cost(options.traversal_cost)) return Error{"build option traversal_cost must lie in [0, 1e6]"};
  if (!is_cost(options.intersection_cost)) return Error{"build option intersection_cost must lie in [0, 1e6]"};
  if (options.bins < 2 || options.bins > kMaxBins)
    return Error{"build option bins is " + std::to_string(options.bins) + "; it must lie in [2, " + std::to_string(kMaxBins) +
                 "]"};
  if (options.max_leaf_size < 1)
    return Error{"build option max_leaf_size is " + std::to_string(options.max_leaf_size) + "; it must be 1 or more"};
  if (options.max_depth < 0 || options.max_depth > kMaxBuildDepth)
    return Error{"build option max_depth is " + std::to_string(options.max_depth) + "; it must lie in [0, " +
                 std::to_string(kMaxBuildDepth) + "]"};
  if (!(options.spatial_overlap >= 0.0f)) return Error{"build option spatial_overlap must be 0 or more"};
  if (!(options.max_duplication >= 0.0f && options.max_duplication <= kMaxDuplication))
    return Error{"build option max_duplication must lie in [0, " + std::to_string(static_cast<int>(kMaxDuplication)) + "]"};
  if (options.reinsertion_rounds < 0 || options.reinsertion_rounds > kMaxReinsertionRounds)
    return Error{"build option reinsertion_rounds is " + std::to_string(options.reinsertion_rounds) + "; it must lie in [0, " +
                 std::to_string(kMaxReinsertionRounds) + "]"};
  if (!(options.reinsertion_seconds >= 0.0f && options.reinsertion_seconds <= std::numeric_limits<float>::max()))
    return Error{"build option reinsertion_seconds must be a number of seconds, 0 or more"};
  if (!(options.empty_bonus >= 0.0f && options.empty_bonus < 1.0f))
    return Error{"build option empty_bonus must be 0 or more, and less than 1"};
  if (!(options.max_references >= 1.0f && options.max_references <= kMaxKdReferences))
    return Error{"build option max_references must lie in [1, " + std::to_string(static_cast<int>(kMaxKdReferences)) + "]"};
  return validate_grid_options(options);
}

void BuildContext::begin_phase(std::string name) {
  end_phase();
  report.phases.push_back({std::move(name), 0.0});
}

BuildReport BuildContext::finish() {
  end_phase();
  report.seconds = std::chrono::duration<double>(Clock::now() - start_).count();
  report.peak_bytes = memory.peak();
  return std::move(report);
}

void BuildContext::end_phase() {
  const Clock::time_point now = Clock::now();
  if (!report.phases.empty()) report.phases.back().seconds = std::chrono::duration<double>(now - phase_start_).count();
  phase_start_ = now;
}

}  // namespace accel
