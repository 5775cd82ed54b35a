// The parallel primitives of pipelines on a CUDA device (exec/cuda/cuda_primitives.cuh) beside a copy of the same array: how
// near they come to the bandwidth of the device's memory. primitives_bench does so for the CPU.
//
//   gpu_primitives [--elements N] [--repeat N]
//
// Gigabytes per second count what each must read and write at least, once. Times are between two events on the device, with the
// allocations that a primitive makes for itself; warm-up first, then the median of the timed runs.
//
// Exit status: 0 ok, 1 error, 2 usage, 5 no device.
#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <iostream>
#include <string>
#include <string_view>
#include <vector>

#include "libaccel/core/counter_rng.h"
#include "libaccel/exec/cuda/cuda_primitives.cuh"

namespace accel::cuda {
namespace {

enum ExitStatus { kOk = 0, kFailed = 1, kUsage = 2, kNoDevice = 5 };

constexpr int kWarmUp = 3;

struct Arguments {
  std::uint32_t elements = 1u << 26;
  std::uint32_t repeat = 21;
};

// Input and output of all primitives.
struct Arrays {
  DeviceArray<std::uint32_t> values, out, ids;
  DeviceArray<std::uint64_t> keys, sorted;
  DeviceArray<std::uint8_t> flags;

  std::size_t size() const { return values.size(); }
};

Result<Arrays> make_arrays(std::size_t n) {
  CounterRng rng(1, n);
  std::vector<std::uint32_t> values(n);
  std::vector<std::uint64_t> keys(n);
  std::vector<std::uint8_t> flags(n);
  for (std::size_t i = 0; i < n; ++i) {
    values[i] = rng.next_below(100), keys[i] = rng.next_u64() >> 32;
    flags[i] = rng.next_below(8) == 0 ? 1 : 0;
  }
  auto device_values = DeviceArray<std::uint32_t>::copy_of(values);
  auto out = DeviceArray<std::uint32_t>::allocate(n), ids = DeviceArray<std::uint32_t>::allocate(n);
  auto device_keys = DeviceArray<std::uint64_t>::copy_of(keys), sorted = DeviceArray<std::uint64_t>::allocate(n);
  auto device_flags = DeviceArray<std::uint8_t>::copy_of(flags);
  if (!device_values) return device_values.error();
  if (!out) return out.error();
  if (!ids) return ids.error();
  if (!device_keys) return device_keys.error();
  if (!sorted) return sorted.error();
  if (!device_flags) return device_flags.error();
  return Arrays{std::move(*device_values), std::move(*out),    std::move(*ids),
                std::move(*device_keys),   std::move(*sorted), std::move(*device_flags)};
}

struct Row {
  const char* name;
  std::size_t bytes;  // read and written, an element
  void (*run)(Arrays&);
};

void copy(Arrays& a) {
  const std::uint32_t* const from = a.values.data();
  std::uint32_t* const to = a.out.data();
  CudaPrimitives::for_each(a.size(), [=] ACCEL_HD_LAMBDA(std::size_t i) { to[i] = from[i]; });
}

void exclusive_scan(Arrays& a) { CudaPrimitives::exclusive_scan(a.values.data(), a.size(), a.out.data()); }

void segmented_scan(Arrays& a) {
  CudaPrimitives::inclusive_segmented_scan(a.values.data(), a.flags.data(), a.size(), a.out.data());
}

void compact(Arrays& a) { CudaPrimitives::compact(a.flags.data(), a.size(), a.out.data()); }

// Sorted keys would tell nothing, so each run begins with a copy.
void sort_pairs(Arrays& a) {
  const std::uint64_t* const from = a.keys.data();
  std::uint64_t* const keys = a.sorted.data();
  std::uint32_t* const ids = a.ids.data();
  CudaPrimitives::for_each(a.size(),
                           [=] ACCEL_HD_LAMBDA(std::size_t i) { keys[i] = from[i], ids[i] = static_cast<std::uint32_t>(i); });
  CudaPrimitives::sort_pairs(keys, ids, a.size());
}

constexpr Row kRows[] = {{"copy", 8, copy},
                         {"exclusive_scan", 8, exclusive_scan},
                         {"segmented_scan", 9, segmented_scan},
                         {"compact", 2, compact},
                         {"sort_pairs", 24, sort_pairs}};

Result<float> time_once(const Row& row, Arrays& arrays) {
  DeviceEvent start, stop;
  if (Status s = start.record(); !s) return s.error();
  if (Status s = caught([&] { row.run(arrays); }); !s) return s.error();
  if (Status s = stop.record(); !s) return s.error();
  return stop.milliseconds_since(start);
}

// Milliseconds in ascending order.
Result<std::vector<float>> measure(const Row& row, Arrays& arrays, std::uint32_t repeat) {
  std::vector<float> times;
  for (int i = -kWarmUp; i < static_cast<int>(repeat); ++i) {
    const auto time = time_once(row, arrays);
    if (!time) return time.error();
    if (i >= 0) times.push_back(*time);
  }
  std::sort(times.begin(), times.end());
  return times;
}

Status measure_all(const Arguments& arguments) {
  ScratchMemoryScope scratch;
  if (Status s = scratch.begin(); !s) return s;
  auto arrays = make_arrays(arguments.elements);
  if (!arrays) return arrays.error();
  double copy_rate = 0;
  std::printf("%-16s %9s %9s %9s %9s\n", "primitive", "GB/s", "min", "max", "of copy");
  for (const Row& row : kRows) {
    const auto times = measure(row, *arrays, arguments.repeat);
    if (!times) return times.error();
    const auto rate = [&](float ms) { return static_cast<double>(row.bytes * arrays->size()) / (ms * 1e6); };
    const std::size_t n = times->size();
    const double median = rate(((*times)[(n - 1) / 2] + (*times)[n / 2]) / 2);
    if (copy_rate == 0) copy_rate = median;
    std::printf("%-16s %9.1f %9.1f %9.1f %9.3f\n", row.name, median, rate(times->back()), rate(times->front()),
                median / copy_rate);
  }
  return Done{};
}

bool parse(int argc, char** argv, Arguments& arguments) {
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string_view flag = argv[i], text = argv[i + 1];
    std::uint32_t& value = flag == "--elements" ? arguments.elements : arguments.repeat;
    if (flag != "--elements" && flag != "--repeat") return false;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || value == 0) return false;
  }
  return argc % 2 == 1;
}

int run(int argc, char** argv) {
  Arguments arguments;
  if (!parse(argc, argv, arguments)) {
    std::cerr << "usage: gpu_primitives [--elements N] [--repeat N]\n";
    return kUsage;
  }
  int devices = 0;
  if (const cudaError_t code = cudaGetDeviceCount(&devices); code != cudaSuccess || devices == 0) {
    std::cerr << "error: no CUDA device: " << (code == cudaSuccess ? "none is visible" : cudaGetErrorString(code)) << '\n';
    return kNoDevice;
  }
  if (const Status s = measure_all(arguments); !s) {
    std::cerr << "error: " << s.message() << '\n';
    return kFailed;
  }
  return kOk;
}

}  // namespace
}  // namespace accel::cuda

int main(int argc, char** argv) { return accel::cuda::run(argc, argv); }
