// Calls a Progress as often as it asks to be called: a few times a second, from one thread at a time.
#pragma once

#include <atomic>
#include <chrono>
#include <mutex>
#include <string_view>

#include "libaccel/core/progress.h"

namespace accel {

class ProgressTicker {
 public:
  ProgressTicker(const Progress& progress, std::string_view phase) : progress_(progress), phase_(phase) {}

  // Says that `fraction` of the phase is done. False when the caller asked to stop, now or earlier. May be called from several
  // threads; costs a clock reading where there is a Progress, and nothing where there is none.
  bool tick(double fraction) {
    if (!progress_) return true;
    if (stopped_.load(std::memory_order_relaxed)) return false;
    const std::unique_lock lock(mutex_, std::try_to_lock);
    const Clock::time_point now = Clock::now();
    if (!lock || now < next_) return true;
    next_ = now + kInterval;
    if (!progress_(phase_, fraction)) stopped_.store(true, std::memory_order_relaxed);
    return !stopped_.load(std::memory_order_relaxed);
  }

  bool stopped() const { return stopped_.load(std::memory_order_relaxed); }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr Clock::duration kInterval = std::chrono::milliseconds(100);

  const Progress& progress_;
  std::string_view phase_;
  std::mutex mutex_;
  Clock::time_point next_ = Clock::time_point::min();
  std::atomic<bool> stopped_{false};
};

}  // namespace accel
