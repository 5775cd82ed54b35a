// Lets oneTBB start as many threads as the user asks for, where that is more than the machine has.
#pragma once

#include <tbb/global_control.h>
#include <tbb/info.h>

#include <algorithm>

namespace accel::apps {

class ThreadLimit {
 public:
  explicit ThreadLimit(int threads)
      : limit_(tbb::global_control::max_allowed_parallelism,
               static_cast<std::size_t>(std::max(threads, tbb::info::default_concurrency()))) {}

 private:
  tbb::global_control limit_;
};

}  // namespace accel::apps
