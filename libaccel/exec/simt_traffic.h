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

#include <algorithm>
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
  void add(Memory memory, bool store, std::uint32_t n, std::uint64_t address, std::uint32_t bytes) {
    Request& request = find(memory, store, n);
    request.bytes += bytes;
    const std::uint64_t last = (address + bytes - 1) / kSectorBytes;
    for (std::uint64_t sector = address / kSectorBytes; sector <= last; ++sector) {
      if (request.sectors.empty() || request.sectors.back() != sector) request.sectors.push_back(sector);
    }
  }

  // Ends the step: its traffic is added to the profile.
  void close(SimtProfile& profile) {
    for (std::size_t i = 0; i < open_; ++i) {
      Request& request = requests_[i];
      SimtProfile::Traffic& traffic = profile.traffic[static_cast<int>(request.memory)];
      std::sort(request.sectors.begin(), request.sectors.end());
      const auto same_line = [](std::uint64_t a, std::uint64_t b) { return a / kSectorsPerLine == b / kSectorsPerLine; };
      const auto sectors_end = std::unique(request.sectors.begin(), request.sectors.end());
      traffic.requests += 1;
      traffic.bytes += request.bytes;
      traffic.sectors += static_cast<std::uint64_t>(sectors_end - request.sectors.begin());
      traffic.lines +=
          static_cast<std::uint64_t>(std::unique(request.sectors.begin(), sectors_end, same_line) - request.sectors.begin());
    }
    open_ = 0;
  }

 private:
  struct Request {
    Memory memory;
    bool store;
    std::uint32_t n;
    std::uint64_t bytes;
    std::vector<std::uint64_t> sectors;
  };

  // A step has few requests, so a linear search finds them; their vectors are kept from step to step.
  Request& find(Memory memory, bool store, std::uint32_t n) {
    for (std::size_t i = 0; i < open_; ++i) {
      Request& request = requests_[i];
      if (request.memory == memory && request.store == store && request.n == n) return request;
    }
    if (open_ == requests_.size()) requests_.emplace_back();
    Request& request = requests_[open_++];
    request.memory = memory, request.store = store, request.n = n, request.bytes = 0;
    request.sectors.clear();
    return request;
  }

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
  void record(Memory memory, bool store, const void* pointer, std::uint32_t bytes) {
    const std::uint32_t n = count_[store ? 1 : 0][static_cast<int>(memory)]++;
    const auto address = reinterpret_cast<std::uintptr_t>(pointer);
    const bool in_stack = address >= stack_ && address < stack_ + stack_bytes_;
    if (!in_stack) return requests_.add(memory, store, n, address, bytes);
    constexpr std::uint32_t kWord = 4;
    const std::uint64_t first_word = (address - stack_) / kWord;
    for (std::uint64_t word = first_word; word * kWord < address - stack_ + bytes; ++word) {
      requests_.add(memory, store, n, (word * kWarpSize + static_cast<std::uint64_t>(lane_)) * kWord, kWord);
    }
  }

  WarpRequests& requests_;
  std::uintptr_t stack_;
  std::size_t stack_bytes_;
  int lane_;
  std::uint32_t count_[2][kMemoryClasses] = {};  // accesses so far: loads, stores
};

}  // namespace accel
