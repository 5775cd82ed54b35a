#include "apps/common/instructions.h"

#include <linux/perf_event.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace accel::apps {

InstructionCounter::InstructionCounter() {
  perf_event_attr event{};
  event.type = PERF_TYPE_HARDWARE;
  event.size = sizeof event;
  event.config = PERF_COUNT_HW_INSTRUCTIONS;
  event.exclude_kernel = event.exclude_hv = 1;
  event.inherit = 1;
  file_ = static_cast<int>(syscall(SYS_perf_event_open, &event, 0, -1, -1, PERF_FLAG_FD_CLOEXEC));
  if (file_ >= 0) return;
  if (errno == EACCES || errno == EPERM)
    reason_ = "counting is not permitted (kernel.perf_event_paranoid)";
  else
    reason_ = std::string("this machine does not count them (") + std::strerror(errno) + ")";
}

InstructionCounter::~InstructionCounter() {
  if (file_ >= 0) ::close(file_);
}

std::optional<std::uint64_t> InstructionCounter::count() const {
  std::uint64_t value = 0;
  if (file_ < 0 || ::read(file_, &value, sizeof value) != sizeof value) return std::nullopt;
  return value;
}

}  // namespace accel::apps
