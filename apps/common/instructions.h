// Instructions that this process executes, in user space, by the machine's counters: repeatable where times are not.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace accel::apps {

// Counts from its creation on, for the calling thread and all threads that it and they start later: make it before any work is
// done in parallel.
class InstructionCounter {
 public:
  InstructionCounter();
  ~InstructionCounter();
  InstructionCounter(const InstructionCounter&) = delete;
  InstructionCounter& operator=(const InstructionCounter&) = delete;

  // So far; nothing where the machine or its administrator does not let us count.
  std::optional<std::uint64_t> count() const;

  // Why there is no count; empty where there is.
  const std::string& reason() const { return reason_; }

 private:
  int file_ = -1;
  std::string reason_;
};

}  // namespace accel::apps
