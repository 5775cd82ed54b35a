// What the benchmark programs share: Google Benchmark's defaults, and the closing table of ratios.
#pragma once

#include <functional>

#include "bench/bench_scenes.h"

namespace accel::bench {

inline constexpr const char* kEmbreeRow = "embree";

// Registers benchmarks, runs them and prints the table; the whole of a main(). Names are GROUP|ROW; the rows of a group are
// compared with its row `baseline`. Repetitions are interleaved at random unless the command line says otherwise.
int run(int argc, char** argv, const std::function<Status(const Options&)>& register_benchmarks,
        const std::string& baseline = kEmbreeRow);

}  // namespace accel::bench
