#include "libaccel/exec/cuda/device_accel.h"

#include <algorithm>
#include <any>
#include <new>
#include <vector>

#include "libaccel/core/out_of_memory.h"
#include "libaccel/core/suggest.h"
#include "libaccel/exec/cuda/device_memory.cuh"
#include "libaccel/exec/cuda/device_method.cuh"
#include "libaccel/registry/any_accel.h"
#include "libaccel/registry/methods.h"

namespace accel {

namespace {

using cuda::DeviceArray;
using cuda::DeviceEvent;
using cuda::DeviceMethod;
using cuda::Launch;
using cuda::LaunchFunction;
using cuda::MultipassMemory;

const std::vector<DeviceMethod>& device_methods() {
  static const std::vector<DeviceMethod> list = [] {
    std::vector<DeviceMethod> result;
    Methods::for_each([&](auto tag) { result.push_back(cuda::make_device_method<typename decltype(tag)::type>()); });
    return result;
  }();
  return list;
}

Result<const DeviceMethod*> find_device_method(std::string_view name) {
  std::vector<std::string_view> names;
  for (const DeviceMethod& method : device_methods()) {
    if (method.name == name) return &method;
    names.push_back(method.name);
  }
  return unknown_name("method", name, names);
}

Result<std::size_t> find_test(std::string_view name) {
  if (name.empty()) return std::size_t{0};
  std::vector<std::string_view> names;
  ModelledTests::for_each([&](auto tag) { names.push_back(decltype(tag)::type::kName); });
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) return unknown_name("triangle test", name, names);
  return static_cast<std::size_t>(found - names.begin());
}

// The time of one launch, without the reset of the ray counter before it.
Result<float> time_launch(LaunchFunction function, const Launch& launch) {
  ACCEL_CUDA_TRY(cudaMemsetAsync(launch.next_ray, 0, sizeof *launch.next_ray));
  DeviceEvent start, stop;
  if (Status s = start.record(); !s) return s.error();
  if (Status s = function(launch); !s) return s.error();
  if (Status s = stop.record(); !s) return s.error();
  return stop.milliseconds_since(start);
}

}  // namespace

Result<DeviceInfo> cuda_device_info() {
  int count = 0, device = 0;
  if (const cudaError_t code = cudaGetDeviceCount(&count); code != cudaSuccess || count == 0) {
    cudaGetLastError();  // which forgets it
    return Error{"no CUDA device: " + std::string(code == cudaSuccess ? "none is visible" : cudaGetErrorString(code))};
  }
  cudaDeviceProp properties;
  DeviceInfo info;
  ACCEL_CUDA_TRY(cudaGetDevice(&device));
  ACCEL_CUDA_TRY(cudaGetDeviceProperties(&properties, device));
  ACCEL_CUDA_TRY(cudaRuntimeGetVersion(&info.runtime_version));
  ACCEL_CUDA_TRY(cudaDriverGetVersion(&info.driver_version));
  info.name = properties.name;
  info.compute_major = properties.major, info.compute_minor = properties.minor;
  info.multiprocessors = properties.multiProcessorCount;
  info.memory_bytes = properties.totalGlobalMem;
  return info;
}

struct DeviceBatch::State {
  DeviceArray<Ray> rays;
  DeviceArray<Hit> hits;
  DeviceArray<std::uint8_t> occluded;
  DeviceArray<std::uint32_t> next_ray;
};

Result<DeviceBatch> DeviceBatch::upload(std::span<const Ray> rays) try {
  if (const auto device = cuda_device_info(); !device) return device.error();
  if (rays.size() > kMaxRays) {
    return Error{std::to_string(rays.size()) + " rays are too many for one batch; trace at most " + std::to_string(kMaxRays)};
  }
  auto on_device = DeviceArray<Ray>::copy_of(rays);
  auto hits = DeviceArray<Hit>::allocate(rays.size());
  auto occluded = DeviceArray<std::uint8_t>::allocate(rays.size());
  auto next_ray = DeviceArray<std::uint32_t>::allocate(1);
  if (!on_device) return on_device.error();
  if (!hits) return hits.error();
  if (!occluded) return occluded.error();
  if (!next_ray) return next_ray.error();
  return DeviceBatch(
      std::make_shared<State>(State{std::move(*on_device), std::move(*hits), std::move(*occluded), std::move(*next_ray)}));
} catch (const std::bad_alloc&) {
  return out_of_memory("uploading rays");
}

std::size_t DeviceBatch::size() const { return state_->rays.size(); }
Status DeviceBatch::hits(std::span<Hit> hits) const { return state_->hits.copy_to(hits); }
Status DeviceBatch::occluded(std::span<std::uint8_t> occluded) const { return state_->occluded.copy_to(occluded); }

struct DeviceAccel::State {
  const DeviceMethod* method;
  std::any view;
  std::vector<std::shared_ptr<const void>> copies;  // what the view points to
  std::size_t bytes;
};

Result<DeviceAccel> DeviceAccel::upload(const AnyStructure& structure, std::string_view method) try {
  const auto found = find_device_method(method);
  if (!found) return found.error();
  const auto bound = AnyAccel::bind(structure, method);
  if (!bound) return bound.error();
  if (const auto device = cuda_device_info(); !device) return device.error();
  cuda::Uploader uploader;
  std::any view = (*found)->upload(bound->structure(), uploader);  // with what the method reads
  if (const Status s = uploader.status(); !s) return s.error();
  const std::size_t bytes = uploader.bytes();
  return DeviceAccel(std::make_shared<const State>(State{*found, std::move(view), uploader.take_copies(), bytes}));
} catch (const std::bad_alloc&) {
  return out_of_memory("uploading a structure");
}

Result<DeviceTiming> DeviceAccel::trace(const DeviceBatch& batch, Query query, const DeviceTraceOptions& options) const try {
  const auto test = find_test(options.test);
  if (!test) return test.error();
  if (batch.size() == 0) return DeviceTiming{};

  DeviceBatch::State& b = *batch.state_;
  const std::size_t by_query = query == Query::any ? 1 : 0;
  const auto ray_count = static_cast<std::uint32_t>(batch.size());
  MultipassMemory in_flight;
  if (options.policy == LaunchPolicy::multipass) {
    auto allocated = MultipassMemory::allocate(std::min(ray_count, options.multipass.batch_size),
                                               state_->method->ray_sizes[*test][by_query]);
    if (!allocated) return allocated.error();
    in_flight = std::move(*allocated);
  }
  cuda::ScratchMemoryScope scratch;
  if (state_->method->makes_packets)
    if (const Status s = scratch.begin(); !s) return s.error();
  const LaunchFunction function = state_->method->kernels[*test][by_query];
  const Launch launch{.view = state_->view,
                      .policy = options.policy,
                      .rays = b.rays.data(),
                      .ray_count = ray_count,
                      .hits = b.hits.data(),
                      .occluded = b.occluded.data(),
                      .next_ray = b.next_ray.data(),
                      .rule = options.multipass.rule,
                      .in_flight = &in_flight,
                      .packet_block = options.packet_block,
                      .packet_queues = options.packet_queues};
  // Bytes that no answer has: what a kernel leaves out must not look like an answer of the trace before.
  if (const Status s = query == Query::any ? b.occluded.fill_bytes(0xff) : b.hits.fill_bytes(0xff); !s) return s.error();
  std::vector<float> times;
  const int repeat = std::max(options.repeat, 1);
  for (int i = -std::max(options.warm_up, 0); i < repeat; ++i) {
    const Result<float> time = time_launch(function, launch);
    if (!time) return time.error();
    if (i >= 0) times.push_back(*time);
  }
  std::sort(times.begin(), times.end());
  return DeviceTiming{times[times.size() / 2], times.front(), times.back()};
} catch (const std::bad_alloc&) {
  return out_of_memory("tracing on a device");
}

std::size_t DeviceAccel::size_bytes() const { return state_->bytes; }

}  // namespace accel
