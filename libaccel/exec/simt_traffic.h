// Memory traffic of the SIMT model: what the lanes of a warp load and store in one step, as warp-wide requests.
//
// The n-th load (store) of a memory class in each active lane belongs to one request, as a load instruction of a warp does. The
// traffic of a request is the number of distinct 128-byte lines and of distinct 32-byte sectors that its lanes touch: what
// caches and memory move on NVIDIA machines. Deviation: a request is as wide as the object that the traverser names, up to 64
// bytes a lane, where hardware issues 16-byte instructions one after the other; the later ones find the lines of the first in
// the cache.
//
// Addresses. Nodes, triangles and hashes: the host's, for buffers start at lines (core/buffer.h) as device memory does. Stacks:
// the host's address means nothing, since a device keeps per-thread arrays in local memory, where the 32-bit words of the 32
// lanes are interleaved. So word w of the stack of lane l is at byte (32 w + l) * 4: lanes at the same stack depth share
// lines, lanes at different depths do not. Rays and hits: byte index * size in an array that starts at a line.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "libaccel/exec/simt_profile.h"

namespace accel {

// The requests of the step in progress.
class WarpRequests {
 public:
  static constexpr std::uint64_t kSectorBytes = 32, kSectorsPerLine = 4;

  // The n-th access of one lane to this class, with this direction.
  void add(Memory memory, bool store, std::uint32_t n, std::uint64_t address, std::uint32_t bytes);

  // Ends the step: its traffic is added to the profile.
  void close(SimtProfile& profile);

 private:
  struct Request {
    Memory memory;
    bool store;
    std::uint32_t n;
    std::uint64_t bytes;
    std::vector<std::uint64_t> sectors;
  };

  // A step has few requests, so a linear search finds them; their vectors are kept from step to step.
  Request& find(Memory memory, bool store, std::uint32_t n);

  std::vector<Request> requests_;  // the first open_ belong to this step
  std::size_t open_ = 0;
};

// The observer of one lane during one step.
class LaneObserver {
 public:
  LaneObserver(WarpRequests& requests, const void* stack, std::size_t stack_bytes, int lane)
      : requests_(requests), stack_(reinterpret_cast<std::uintptr_t>(stack)), stack_bytes_(stack_bytes), lane_(lane) {}

  void load(Memory memory, const void* address, std::uint32_t bytes) { record(memory, false, address, bytes); }
  void store(Memory memory, const void* address, std::uint32_t bytes) { record(memory, true, address, bytes); }
  void node_step() {}
  void leaf_visit(std::uint32_t) {}
  void box_tests(std::uint32_t) {}
  void triangle_test() {}
  void backtrack() {}

 private:
  void record(Memory memory, bool store, const void* pointer, std::uint32_t bytes);

  WarpRequests& requests_;
  std::uintptr_t stack_;
  std::size_t stack_bytes_;
  int lane_;
  std::uint32_t count_[2][kMemoryClasses] = {};  // accesses so far: loads, stores
};

}  // namespace accel
