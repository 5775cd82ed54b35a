// What the mains of all programs do.
#pragma once

#include <functional>
#include <string>

#include "apps/common/failure.h"
#include "apps/common/terminal.h"

namespace accel::apps {

// Sets up signals, runs the body, and turns what it returns into an exit status and, for failures, a line on standard error.
// Nothing escapes: running out of memory is an error like any other.
int run_program(const std::string& name, const std::function<Outcome<ExitStatus>(Terminal&)>& body);

// Prints and ends well, or fails where it cannot print.
Outcome<ExitStatus> answer(const Terminal& terminal, std::string_view text);

}  // namespace accel::apps
