// How long-running functions tell their caller how far they are, and how the caller stops them.
#pragma once

#include <functional>
#include <string_view>

namespace accel {

// Called from one thread at a time, ten times a second at most, with the phase's name and the share of it that is done (0 to
// 1). Short phases may go by without a call, and the last call need not be of all. Returning false asks the function to stop:
// it then returns an Error whose message is kInterrupted. An empty function is never called. What a callback throws comes out
// of the function that called it, but for std::bad_alloc, which is an Error.
using Progress = std::function<bool(std::string_view phase, double fraction)>;

inline constexpr std::string_view kInterrupted = "interrupted";

}  // namespace accel
