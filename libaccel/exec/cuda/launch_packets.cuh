// Batches of rays as packets, on a device: the pipeline of packet/packet_batch.h, and the kernel of single rays for what is
// left.
//
// What knows of CUB is compiled once, in launch_packets.cu, for all methods that trace packets: they differ in their builders.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>

#include "libaccel/core/hit.h"
#include "libaccel/core/ray.h"
#include "libaccel/core/result.h"
#include "libaccel/exec/batch_traverser.h"
#include "libaccel/exec/cuda/device_method.cuh"

namespace accel {
struct Bvh2View;
struct PacketOptions;
}  // namespace accel

namespace accel::cuda {

// Traversers that CPUs run as packets.
template <class Traverser>
concept PacketTraverser = BatchTraverser<Traverser> && std::same_as<BatchOptions<Traverser>, PacketOptions>;

// Traces rays one by one: `others` has their copies and the places of all answers of their block; ids[i] is the place of ray
// i's.
using TraceOthers = std::function<Status(const Launch& others, const std::uint32_t* ids)>;

// `test` is an index into ModelledTests.
Status launch_packets(const Bvh2View& view, std::size_t test, Query query, const Launch& launch,
                      const TraceOthers& trace_others);

}  // namespace accel::cuda
