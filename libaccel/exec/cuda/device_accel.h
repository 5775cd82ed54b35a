// Structures and rays on a CUDA device, and every method of the registry as a kernel. Plain C++: no CUDA type appears here.
//
// DeviceAccel is AnyAccel's twin (registry/any_accel.h) on the device, and its hits are the same, bit for bit: the kernels are
// the same state machines, compiled without contraction of multiplies and adds.
//
//   auto batch = DeviceBatch::upload(rays);
//   auto scene = DeviceAccel::upload(structure, "sbvh/stack");
//   auto timing = scene->trace(*batch, Query::closest);
//   auto status = batch->hits(hits);
//
// Errors. Every function fails with a message where the library was built without CUDA, where there is no device, and where a
// call of the CUDA run-time fails, whose name and reason the message has. cuda_device_info() tells the first two before any
// work.
//
// This folder alone may look up to the registry: a kernel is instantiated for every line of registry/methods.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "libaccel/core/hit.h"
#include "libaccel/core/ray.h"
#include "libaccel/core/result.h"
#include "libaccel/exec/multipass_profile.h"
#include "libaccel/registry/any_structure.h"

namespace accel {

struct DeviceInfo {
  std::string name;
  int compute_major = 0, compute_minor = 0;  // compute capability
  int multiprocessors = 0;
  std::uint64_t memory_bytes = 0;
  int runtime_version = 0, driver_version = 0;  // 1000 * major + 10 * minor
};

// The current device, or why there is none.
Result<DeviceInfo> cuda_device_info();

// How rays meet threads: for grid and persistent see trace_kernel.cuh; multipass runs small kernels pass after pass, see
// multipass_kernel.cuh.
enum class LaunchPolicy : std::uint8_t { grid, persistent, multipass };
inline constexpr int kLaunchPolicies = 3;

// "grid", "persistent", "multipass"
constexpr const char* policy_name(LaunchPolicy policy) {
  constexpr const char* kNames[kLaunchPolicies] = {"grid", "persistent", "multipass"};
  return kNames[static_cast<int>(policy)];
}

struct DeviceTraceOptions {
  LaunchPolicy policy = LaunchPolicy::persistent;
  std::string_view test;  // a name of modelled_tests(); empty: the first
  int warm_up = 0;        // launches before the timed ones
  int repeat = 1;         // timed launches, at least one

  // Multipass: the rule, and the most rays in flight, fewer where the device's memory is short. Rays are always compacted.
  MultipassOptions multipass = {.batch_size = 1u << 22, .compact = true};

  // Methods that trace packets (packet/packet_batch.h): the most rays in a block, fewer where the device's memory is short. The
  // policy is that of the rays that packets leave; multipass makes no packets.
  std::uint32_t packet_block = 1u << 22;
  // And whether the lanes of warps take what there is to test from queues (packet/localized_warp.h), instead of a ray each.
  bool packet_queues = false;
};

// Time of a launch between two events on the device, in milliseconds: copies to and from the device are not in it, but those
// between the passes of multipass are.
struct DeviceTiming {
  float median_ms = 0, min_ms = 0, max_ms = 0;
};

// Rays on the device, and room for their answers. One trace at a time.
class DeviceBatch {
 public:
  // The most rays of a batch: ray numbers are 32-bit, and warps may ask for some more than there are.
  static constexpr std::size_t kMaxRays = std::size_t{1} << 31;

  static Result<DeviceBatch> upload(std::span<const Ray> rays);
  std::size_t size() const;

  // The answers of the last trace with Query::closest (any). The span has the size of the batch.
  Status hits(std::span<Hit> hits) const;
  Status occluded(std::span<std::uint8_t> occluded) const;

 private:
  friend class DeviceAccel;
  struct State;
  explicit DeviceBatch(std::shared_ptr<State> state) : state_(std::move(state)) {}
  std::shared_ptr<State> state_;
};

class DeviceAccel {
 public:
  // Copies a structure to the device. Fails as AnyAccel::bind() does if the method cannot trace it: wrong kind, or too deep.
  static Result<DeviceAccel> upload(const AnyStructure& structure, std::string_view method);

  // Answers all rays of the batch. Every launch is waited for.
  Result<DeviceTiming> trace(const DeviceBatch& batch, Query query, const DeviceTraceOptions& options = {}) const;

  std::size_t size_bytes() const;  // on the device

 private:
  struct State;
  explicit DeviceAccel(std::shared_ptr<const State> state) : state_(std::move(state)) {}
  std::shared_ptr<const State> state_;
};

}  // namespace accel
