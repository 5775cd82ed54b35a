// A progress bar on standard error, and the Progress callback that moves it.
//
// Automatic bars appear only on terminals, and only once a phase has taken a second. The callback also carries interruptions
// into the library: it returns false after one.
#pragma once

#include <chrono>
#include <string>
#include <string_view>

#include "apps/common/terminal.h"
#include "libaccel/core/progress.h"

namespace accel::apps {

class ProgressBar {
 public:
  ProgressBar(When when, bool quiet);
  ~ProgressBar() { clear(); }
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  // A new piece of work, `what` ("building sbvh"), whose phases report through the callback below.
  void begin(std::string what);

  // Shows the share that is done and returns whether to go on.
  bool update(std::string_view phase, double fraction);

  // Takes the bar off the screen. Needed before anything else is printed.
  void clear();

  // Calls update(); valid while the bar lives.
  Progress callback() {
    return [this](std::string_view phase, double fraction) { return update(phase, fraction); };
  }

 private:
  using Clock = std::chrono::steady_clock;

  void draw(std::string_view phase, double fraction);

  bool enabled_ = false, eager_ = false, drawn_ = false;
  std::string what_;
  Clock::time_point start_, last_draw_;
};

}  // namespace accel::apps
