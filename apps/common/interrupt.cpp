#include "apps/common/interrupt.h"

#include <csignal>

namespace accel::apps {

namespace {

volatile std::sig_atomic_t caught_signal = 0;  // 0: none yet

void on_interrupt(int signal) {
  caught_signal = signal;
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
}

}  // namespace

void catch_interrupts() {
  std::signal(SIGINT, on_interrupt);
  std::signal(SIGTERM, on_interrupt);
}

bool interrupted() { return caught_signal != 0; }

ExitStatus interruption_status() { return caught_signal == SIGTERM ? ExitStatus::terminated : ExitStatus::interrupted; }

}  // namespace accel::apps
