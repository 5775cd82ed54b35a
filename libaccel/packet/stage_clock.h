// The stages of a batch pipeline, and how long each takes: Garanzha and Loop 2010, Fig. 1 and 13.
#pragma once

#include <chrono>
#include <cstdint>
#include <numeric>

namespace accel {

// `rest`: rays that no frustum serves, one by one.
enum class PacketStage : std::uint8_t { hash, compress, sort, decompress, ranges, frustums, traversal, localized, rest };
inline constexpr int kPacketStages = 9;
constexpr const char* name_of(PacketStage stage) {
  constexpr const char* kNames[kPacketStages] = {"hash",     "compress",  "sort",      "decompress", "ranges",
                                                 "frustums", "traversal", "localized", "rest"};
  return kNames[static_cast<int>(stage)];
}

struct StageTimes {
  double seconds[kPacketStages] = {};

  double of(PacketStage stage) const { return seconds[static_cast<int>(stage)]; }
  double total() const { return std::accumulate(seconds, seconds + kPacketStages, 0.0); }
};

// Pipelines and stages call lap(stage) when the stage ends: it has taken the time since the lap before.
class StageClock {
 public:
  explicit StageClock(StageTimes& times) : times_(times), last_(Clock::now()) {}

  void lap(PacketStage stage) {
    const Clock::time_point now = Clock::now();
    times_.seconds[static_cast<int>(stage)] += std::chrono::duration<double>(now - last_).count();
    last_ = now;
  }

 private:
  using Clock = std::chrono::steady_clock;
  StageTimes& times_;
  Clock::time_point last_;
};
struct NoClock {
  void lap(PacketStage) {}
};

}  // namespace accel
