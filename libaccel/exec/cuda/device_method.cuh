// The kernels of one method, and how its structure comes to the device. The device's twin of registry/method_entry.h, made
// likewise in an object file of its own.
#pragma once

#include <any>
#include <array>
#include <cstdint>
#include <string>

#include "libaccel/core/hit.h"
#include "libaccel/core/ray.h"
#include "libaccel/core/result.h"
#include "libaccel/exec/cuda/device_accel.h"
#include "libaccel/exec/cuda/multipass_memory.cuh"
#include "libaccel/exec/cuda/upload.cuh"
#include "libaccel/registry/any_structure.h"
#include "libaccel/registry/method.h"

namespace accel::cuda {

// What a launch works on. The view is a Traverser::View, with pointers to device memory.
struct Launch {
  const std::any& view;
  LaunchPolicy policy;
  const Ray* rays;
  std::uint32_t ray_count;
  Hit* hits;                   // for closest; multipass works on them for any, too
  std::uint8_t* occluded;      // for any
  std::uint32_t* next_ray;     // persistent
  MultipassRule rule;          // multipass
  MultipassMemory* in_flight;  // multipass
  std::uint32_t packet_block;  // packets: rays of a block
  bool packet_queues;          // packets: see DeviceTraceOptions
};

using LaunchFunction = Status (*)(const Launch&);

struct DeviceMethod {
  std::string name;
  bool makes_packets;  // see launch_packets.cuh

  std::any (*upload)(const AnyStructure&, Uploader&);                      // the view of a structure of the method's kind
  std::array<std::array<LaunchFunction, 2>, ModelledTests::size> kernels;  // by test and query
  std::array<std::array<RaySizes, 2>, ModelledTests::size> ray_sizes;      // likewise
};

// Defined in instantiate_device_method.cuh.
template <class Method>
DeviceMethod make_device_method();

}  // namespace accel::cuda
