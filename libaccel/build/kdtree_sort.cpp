#include "libaccel/build/kdtree_sort.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace accel {
namespace {

// Below this, counting digits costs more than comparing.
constexpr std::uint32_t kRadixSize = 2048;

constexpr int kDigitBits = 11, kEventDigits = 3;
constexpr std::uint32_t kDigitMask = (1u << kDigitBits) - 1;

// Position and kind as an integer of 33 bits in the order of events.
std::uint64_t key_of(const KdEvent& event) {
  const auto bits = std::bit_cast<std::uint32_t>(event.position);
  const std::uint32_t ordered = bits ^ (static_cast<std::uint32_t>(static_cast<std::int32_t>(bits) >> 31) | 0x80000000u);
  return std::uint64_t{ordered} << 1 | (event.is_start() ? 1u : 0u);
}
std::uint32_t digit_of(const KdEvent& event, int digit) {
  return static_cast<std::uint32_t>(key_of(event) >> (digit * kDigitBits)) & kDigitMask;
}

// Least digit first. Each pass keeps the order of equals, which is that of references to begin with.
void radix_sort(KdEvent* events, std::uint32_t count, ScratchStack& scratch) {
  const ScratchStack::Mark mark = scratch.mark();
  using Counts = std::uint32_t[kDigitMask + 1];
  Counts* const next = scratch.allocate<Counts>(kEventDigits);  // where the next event with a digit goes
  for (int digit = 0; digit < kEventDigits; ++digit) std::fill(std::begin(next[digit]), std::end(next[digit]), 0u);
  for (std::uint32_t i = 0; i < count; ++i)
    for (int digit = 0; digit < kEventDigits; ++digit) ++next[digit][digit_of(events[i], digit)];
  KdEvent *from = events, *to = scratch.allocate<KdEvent>(count);
  for (int digit = 0; digit < kEventDigits; ++digit) {
    std::uint32_t sum = 0;
    for (std::uint32_t& n : next[digit]) sum += std::exchange(n, sum);
    for (std::uint32_t i = 0; i < count; ++i) to[next[digit][digit_of(from[i], digit)]++] = from[i];
    std::swap(from, to);
  }
  std::copy(from, from + count, events);
  scratch.release(mark);
}

}  // namespace

void sort_events(KdEvent* events, std::uint32_t count, ScratchStack& scratch) {
  if (count < kRadixSize) {
    std::sort(events, events + count);
  } else {
    radix_sort(events, count, scratch);
  }
}

// From the back, so that events find their places.
void merge_events(KdEventList& list, const KdEventList& added) {
  std::uint32_t from = list.size, next = added.size, to = list.size + added.size;
  list.size = to, list.starts += added.starts;
  while (next > 0) {
    if (from > 0 && added.events[next - 1] < list.events[from - 1]) {
      list.events[--to] = list.events[--from];
    } else {
      list.events[--to] = added.events[--next];
    }
  }
}

}  // namespace accel
