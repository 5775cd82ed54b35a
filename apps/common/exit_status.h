// The exit statuses of the command lines.
#pragma once

namespace accel::apps {

enum class ExitStatus : int {
  ok = 0,
  error = 1,          // bad input, or the run failed
  usage = 2,          // the command line makes no sense
  mismatch = 3,       // verification found a wrong answer
  unavailable = 5,    // a backend is not built in, or there is no device for it
  interrupted = 130,  // by SIGINT
  terminated = 143,   // by SIGTERM
};

}  // namespace accel::apps
