#include "apps/common/progress_bar.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <limits>

#include "apps/common/interrupt.h"
#include "apps/common/text.h"

namespace accel::apps {

namespace {

constexpr auto kPatience = std::chrono::seconds(1);  // before an automatic bar appears
constexpr auto kRedrawInterval = std::chrono::milliseconds(100);
constexpr int kBarCells = 24;

// A line that is longer wraps, and is not cleared as a whole.
std::size_t terminal_width() {
  winsize size{};
  const bool known = ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  return known ? size.ws_col : std::numeric_limits<std::size_t>::max();
}

}  // namespace

ProgressBar::ProgressBar(When when, bool quiet)
    : enabled_(when == When::always || (when == When::automatic && !quiet && isatty(STDERR_FILENO) != 0)),
      eager_(when == When::always) {}

void ProgressBar::begin(std::string what) {
  clear();
  what_ = std::move(what);
  start_ = Clock::now();
  last_draw_ = {};
}

bool ProgressBar::update(std::string_view phase, double fraction) {
  if (interrupted()) return false;
  const auto now = Clock::now();
  const bool due = now - last_draw_ >= kRedrawInterval && (eager_ || now - start_ >= kPatience);
  if (enabled_ && due) {
    last_draw_ = now;
    draw(phase, std::clamp(fraction, 0.0, 1.0));
  }
  return true;
}

void ProgressBar::draw(std::string_view phase, double fraction) {
  const int full = static_cast<int>(fraction * kBarCells + 0.5);
  const std::string cells =
      std::string(static_cast<std::size_t>(full), '=') + std::string(static_cast<std::size_t>(kBarCells - full), ' ');
  const double elapsed = std::chrono::duration<double>(Clock::now() - start_).count();
  const std::string line =
      "\r\x1b[K" + clipped(print("[%s] %3.0f %%  %s: %.*s, %s", cells.c_str(), 100 * fraction, what_.c_str(),
                                 static_cast<int>(phase.size()), phase.data(), seconds_text(elapsed).c_str()),
                           terminal_width());
  std::fwrite(line.data(), 1, line.size(), stderr);
  std::fflush(stderr);
  drawn_ = true;
}

void ProgressBar::clear() {
  if (drawn_) std::fputs("\r\x1b[K", stderr);
  drawn_ = false;
}

}  // namespace accel::apps
