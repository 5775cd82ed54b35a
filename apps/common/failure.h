// Why a command ends early: a message for the user and the exit status that goes with it.
#pragma once

#include <string>
#include <utility>
#include <variant>

#include "apps/common/exit_status.h"
#include "apps/common/interrupt.h"
#include "libaccel/core/progress.h"
#include "libaccel/core/result.h"

namespace accel::apps {

struct Failure {
  ExitStatus status = ExitStatus::error;
  std::string message;

  Failure(ExitStatus exit_status, std::string text) : status(exit_status), message(std::move(text)) {}

  // A library error: an interruption, or a failed run.
  Failure(const Error& error)
      : status(error.message == kInterrupted ? interruption_status() : ExitStatus::error), message(error.message) {}
};

// What is wrong with the command line.
inline Failure usage_error(std::string message) { return {ExitStatus::usage, std::move(message)}; }

// A value, or the reason to stop. As Result, with an exit status.
template <class T>
class [[nodiscard]] Outcome {
 public:
  Outcome(T value) : state_(std::in_place_index<0>, std::move(value)) {}
  Outcome(Failure failure) : state_(std::in_place_index<1>, std::move(failure)) {}
  Outcome(const Error& error) : Outcome(Failure(error)) {}

  explicit operator bool() const { return state_.index() == 0; }
  T& operator*() & { return *std::get_if<0>(&state_); }
  const T& operator*() const& { return *std::get_if<0>(&state_); }
  T&& operator*() && { return std::move(*std::get_if<0>(&state_)); }
  T* operator->() { return &**this; }
  const T* operator->() const { return &**this; }
  const Failure& failure() const { return *std::get_if<1>(&state_); }

 private:
  std::variant<T, Failure> state_;
};

using Finished = Outcome<Done>;

}  // namespace accel::apps
