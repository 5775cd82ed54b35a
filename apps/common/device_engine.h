// Methods as engines on a CUDA device.
#pragma once

#include <string>

#include "apps/common/measure.h"

namespace accel::apps {

// "NVIDIA H200, compute capability 9.0", or why there is none (unavailable).
Outcome<std::string> find_device();

// Copies the structure to the device. The time of the engine's calls is that of the kernels: rays and hits are copied outside
// of it. The test's name must outlive the engine.
Outcome<Engine> device_engine_of(const AnyAccel& accel, std::string_view test);

}  // namespace accel::apps
