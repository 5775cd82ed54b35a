#include "libaccel/exec/simt_traffic.h"

#include <algorithm>

namespace accel {

void WarpRequests::add(Memory memory, bool store, std::uint32_t n, std::uint64_t address, std::uint32_t bytes) {
  Request& request = find(memory, store, n);
  request.bytes += bytes;
  const std::uint64_t last = (address + bytes - 1) / kSectorBytes;
  for (std::uint64_t sector = address / kSectorBytes; sector <= last; ++sector) {
    if (request.sectors.empty() || request.sectors.back() != sector) request.sectors.push_back(sector);
  }
}

void WarpRequests::close(SimtProfile& profile) {
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

WarpRequests::Request& WarpRequests::find(Memory memory, bool store, std::uint32_t n) {
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

void LaneObserver::record(Memory memory, bool store, const void* pointer, std::uint32_t bytes) {
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

}  // namespace accel
