// A value, or a message that says what went wrong and what to do.
//
// Nothing in libaccel prints, exits or throws across its interface: functions that can fail return a Result. Messages name the
// file, line or element, start in lower case and have no full stop, so that callers can put them behind "error: ".
#pragma once

#include <string>
#include <utility>
#include <variant>

#include "libaccel/core/hd.h"

namespace accel {

struct Error {
  std::string message;
};

template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

  bool ok() const { return state_.index() == 0; }
  explicit operator bool() const { return ok(); }

  // The value; only when ok().
  T& value() & { return ACCEL_ASSERT(ok()), *std::get_if<0>(&state_); }
  const T& value() const& { return ACCEL_ASSERT(ok()), *std::get_if<0>(&state_); }
  T&& value() && { return ACCEL_ASSERT(ok()), std::move(*std::get_if<0>(&state_)); }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T&& operator*() && { return std::move(*this).value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

  // The error; only when not ok().
  const Error& error() const { return ACCEL_ASSERT(!ok()), *std::get_if<1>(&state_); }
  const std::string& message() const { return error().message; }

 private:
  std::variant<T, Error> state_;
};

// The result of a function that has nothing to return but may fail.
struct Done {};
using Status = Result<Done>;

}  // namespace accel
