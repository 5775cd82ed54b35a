#include "libaccel/packet/packet_ranges.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "libaccel/core/counter_rng.h"
#include "libaccel/packet/cpu_primitives.h"
#include "libaccel/packet/serial_primitives.h"

namespace accel {
namespace {

template <class Primitives>
std::vector<std::uint32_t> bases(const std::vector<std::uint8_t>& keys, std::uint32_t max_size) {
  const auto ranges = packet_ranges<Primitives>(keys.data(), keys.size(), max_size);
  return {ranges.base.begin(), ranges.base.begin() + ranges.count + 1};
}

// Garanzha and Loop 2010, Fig. 6: chunks in packets of at most four.
TEST(PacketRanges, ThePapersExample) {
  const std::vector<std::uint8_t> keys{0, 0, 0, 1, 1, 1, 1, 1, 1, 2, 2, 3, 3, 3, 3, 3, 3, 3, 3, 3};
  EXPECT_THAT(bases<SerialPrimitives>(keys, 4), testing::ElementsAre(0, 3, 7, 9, 11, 15, 19, 20));
}

TEST(PacketRanges, OfNothing) { EXPECT_THAT(bases<SerialPrimitives>({}, 4), testing::ElementsAre(0)); }

// As a loop would cut them; in parallel too.
TEST(PacketRanges, NoPacketMixesKeysAndAllAreAsLongAsCanBe) {
  for (const std::uint32_t run : {1u, 5u, 400u}) {
    CounterRng rng(1, run);
    std::vector<std::uint8_t> keys;
    while (keys.size() < 30000) keys.insert(keys.end(), 1 + rng.next_below(run), static_cast<std::uint8_t>(rng.next_below(5)));
    for (const std::uint32_t max_size : {1u, 7u, 256u}) {
      std::vector<std::uint32_t> expected;
      for (std::uint32_t i = 0; i < keys.size(); ++i)
        if (i == 0 || keys[i] != keys[i - 1] || i - expected.back() == max_size) expected.push_back(i);
      expected.push_back(static_cast<std::uint32_t>(keys.size()));
      EXPECT_EQ(bases<SerialPrimitives>(keys, max_size), expected);
      EXPECT_EQ(bases<CpuPrimitives>(keys, max_size), expected);
    }
  }
}

// Those of all rays, and of the rays without a face; faces that no ray has.
TEST(PacketRanges, OfFacesThatAscend) {
  for (const std::vector<std::uint32_t>& counts : std::vector<std::vector<std::uint32_t>>{
           {}, {1}, {0, 0, 9}, {4, 4, 4, 4, 4, 4, 4}, {0, 300, 1, 0, 7, 0, 12}, {0, 0, 0, 0, 0, 0, 5}}) {
    std::vector<std::uint8_t> faces;
    for (std::size_t face = 0; face < counts.size(); ++face)
      faces.insert(faces.end(), counts[face], static_cast<std::uint8_t>(face));
    for (const std::uint32_t max_size : {1u, 4u, 256u}) {
      const auto ranges = ranges_of_faces<SerialPrimitives>(faces, max_size);
      const std::vector<std::uint32_t> base(ranges.base.begin(), ranges.base.begin() + ranges.count + 1);
      EXPECT_EQ(base, bases<SerialPrimitives>(faces, max_size));
    }
  }
}

}  // namespace
}  // namespace accel
