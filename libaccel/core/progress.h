// How long-running functions tell their caller how far they are, and how the caller stops them.
#pragma once

#include <functional>
#include <string_view>

namespace accel {

// Called from one thread at a time, a few times a second at most, with the phase's name and the share of it that is done (0 to 1).
// Returning false asks the function to stop: it then returns an Error that says "interrupted". An empty function is never called.
using Progress = std::function<bool(std::string_view phase, double fraction)>;

inline constexpr std::string_view kInterrupted = "interrupted";

}  // namespace accel
