// What the benchmark programs share: Google Benchmark's defaults, and the closing table of ratios to Embree.
#pragma once

#include <functional>

#include "bench/bench_scenes.h"

namespace accel::bench {

// The row of a benchmark that the others of its group are compared with.
inline constexpr const char* kEmbreeRow = "embree";

// Registers benchmarks, runs them and prints the table; the whole of a main(). Names are GROUP/.../ROW: the part before the
// last
// '|' is the group, the part behind it the row. Repetitions are interleaved at random unless the command line says otherwise.
int run(int argc, char** argv, const std::function<Status(const Options&)>& register_benchmarks);

}  // namespace accel::bench
