// Where a traversal without a stack is: the bit trail and the key of the node that it is in.
//
// Binder and Keller 2016 [BK16], section 2.1 and 2.2: both are shifted left on the way down. The trail's last bit says whether
// the node's sibling has been postponed, the next whether the uncle has, and so on; the key's bits say which turns were taken.
// Going up to the nearest postponed node is one shift of both, by the number of the trail's trailing zeros.
//
// Widths. NodePath serves trees as deep as its words are wide, less one. PackedPath has two words of 32 bits in one of 64, so
// that machines with such registers shift both at once; of its low bits, none but zeros cross from the trail into the key.
// DeepPath serves trees of any depth that a builder makes: when 64 bits are full, their upper half moves to memory, and it
// comes back when the lower half is used up. [BK16], section 3, keeps the overflow of each value in memory likewise. The window
// never has fewer than 32 turns while there are others in memory, so whoever looks at the last bits of the trail finds them.
//
//   void begin();
//   Word hashed_key() const;              // of 32 or 64 bits
//   void step_down(std::uint32_t side, bool postponed, std::uint64_t multiplier, Observer&);  // the hash's multiplier
//   bool is_postponed(int level) const;   // the sibling of the ancestor `level` levels up; 0: the node's own; level < 4
//   bool is_finished() const;             // nothing has been postponed
//   void rise(int levels, Observer&);     // to an ancestor below which nothing is postponed any more; levels < 32
//   bool rise_to_postponed(Observer&);    // to the node whose sibling was postponed most recently; false: there is none
//   bool drop_postponed();                // the sibling that was postponed most recently is not; false: cannot tell which
//   void cross();                         // to the sibling, which is then no longer postponed
#pragma once

#include <bit>
#include <cstdint>

#include "libaccel/structure/bvh2.h"
#include "libaccel/trace/traverser.h"

namespace accel {

// The number of trailing zeros; not of 0.
ACCEL_HD int trailing_zeros(std::uint64_t bits) { return std::countr_zero(bits); }
ACCEL_HD int trailing_zeros(std::uint32_t bits) { return std::countr_zero(bits); }

template <class Bits>
struct NodePath {
  using Word = Bits;

  // What a traverser with such a path inherits.
  struct Traits {
    static constexpr std::uint32_t kMaxDepth = 8 * sizeof(Word) - 1;
    static constexpr bool kForDevices = sizeof(Word) == 4;  // half the registers of 64 bits
  };

  Word trail, key;

  ACCEL_HD void begin() { trail = 0, key = 1; }
  ACCEL_HD Word hashed_key() const { return key; }

  template <class Observer>
  ACCEL_HD void step_down(std::uint32_t side, bool postponed, std::uint64_t, Observer&) {
    trail = static_cast<Word>(trail << 1 | (postponed ? 1u : 0u));
    key = static_cast<Word>(key << 1 | side);
  }
  ACCEL_HD bool is_postponed(int level) const { return (trail >> level & 1u) != 0; }
  ACCEL_HD bool is_finished() const { return trail == 0; }

  template <class Observer>
  ACCEL_HD void rise(int levels, Observer&) {
    trail >>= levels, key >>= levels;
  }
  template <class Observer>
  ACCEL_HD bool rise_to_postponed(Observer& observer) {
    if (trail == 0) return false;
    rise(trailing_zeros(trail), observer);
    return true;
  }
  ACCEL_HD bool drop_postponed() {
    trail &= trail - 1;
    return true;
  }
  ACCEL_HD void cross() { trail ^= 1u, key ^= 1u; }
};

struct PackedPath {
  using Word = std::uint64_t;
  struct Traits {
    static constexpr std::uint32_t kMaxDepth = kMaxDepth32;
  };
  static constexpr int kTrailAt = 32;
  static constexpr Word kPostponed = Word{1} << kTrailAt;  // the trail's last bit

  Word word;  // the trail above the key

  ACCEL_HD void begin() { word = 1; }
  ACCEL_HD std::uint32_t hashed_key() const { return static_cast<std::uint32_t>(word); }

  template <class Observer>
  ACCEL_HD void step_down(std::uint32_t side, bool postponed, std::uint64_t, Observer&) {
    word = word * 2 + ((postponed ? kPostponed : 0) + side);
  }
  ACCEL_HD bool is_postponed(int level) const { return (word >> (kTrailAt + level) & 1u) != 0; }
  ACCEL_HD bool is_finished() const { return word < kPostponed; }

  template <class Observer>
  ACCEL_HD void rise(int levels, Observer&) {
    word >>= levels;
  }
  template <class Observer>
  ACCEL_HD bool rise_to_postponed(Observer& observer) {
    if (is_finished()) return false;
    rise(trailing_zeros(static_cast<std::uint32_t>(word >> kTrailAt)), observer);
    return true;
  }
  ACCEL_HD bool drop_postponed() {
    word &= (word - kPostponed) | (kPostponed - 1);
    return true;
  }
  ACCEL_HD void cross() { word ^= kPostponed | 1u; }
};

struct DeepPath {
  using Word = std::uint64_t;

  // The upper halves of a full window.
  struct Half {
    std::uint64_t prefix;
    std::uint32_t key, trail;
  };
  static_assert(sizeof(Half) == 16);
  static constexpr int kMaxHalves = 32;
  static constexpr int kTurnsOfHalf = 31;  // of a half's bits one leads

  // Addressed at run time: see trace/traverser.h.
  struct Stack {
    Half halves[kMaxHalves];
  };
  struct Traits {
    using Stack = DeepPath::Stack;
    static constexpr std::uint32_t kMaxDepth = kMaxDepth64 + kTurnsOfHalf * kMaxHalves;
  };

  std::uint64_t trail;
  NodeKey key;
  std::uint32_t halves;  // in memory
  Stack* stack;

  ACCEL_HD void begin() { trail = 0, key = NodeKey{}, halves = 0; }
  ACCEL_HD std::uint64_t hashed_key() const { return key.hashed(); }

  template <class Observer>
  ACCEL_HD void step_down(std::uint32_t side, bool postponed, std::uint64_t multiplier, Observer& observer) {
    if (key.is_full()) fold(multiplier, observer);
    trail = trail << 1 | (postponed ? 1u : 0u);
    key.window = key.window << 1 | side;
  }
  ACCEL_HD bool is_postponed(int level) const { return (trail >> level & 1u) != 0; }
  ACCEL_HD bool is_finished() const { return trail == 0 && halves == 0; }

  template <class Observer>
  ACCEL_HD void rise(int levels, Observer& observer) {
    trail >>= levels, key.window >>= levels;
    while (halves > 0 && key.window >> kLeastTurns == 0) unfold(observer);
  }
  template <class Observer>
  ACCEL_HD bool rise_to_postponed(Observer& observer) {
    while (trail == 0) {
      if (halves == 0) return false;
      const Half& half = load_half(observer);
      trail = half.trail, key = {half.key, half.prefix};
    }
    rise(trailing_zeros(trail), observer);
    return true;
  }
  ACCEL_HD bool drop_postponed() {
    const bool in_window = trail != 0;
    trail &= trail - 1;
    return in_window;
  }
  ACCEL_HD void cross() { trail ^= 1u, key.window ^= 1u; }

 private:
  template <class Observer>
  ACCEL_HD void fold(std::uint64_t multiplier, Observer& observer) {
    ACCEL_ASSERT(halves < kMaxHalves);
    Half& half = stack->halves[halves++];
    observer.store(Memory::stack, &half, sizeof half);
    half = {key.prefix, key.upper_half(), static_cast<std::uint32_t>(trail >> 32)};
    key.fold(multiplier);
    trail &= 0xffffffffu;
  }
  template <class Observer>
  ACCEL_HD const Half& load_half(Observer& observer) {
    const Half& half = stack->halves[--halves];
    observer.load(Memory::stack, &half, sizeof half);
    return half;
  }
  // The turns that are left in the window go below those that come back.
  template <class Observer>
  ACCEL_HD void unfold(Observer& observer) {
    const int turns = std::bit_width(key.window) - 1;
    const Half& half = load_half(observer);
    const std::uint64_t below = (std::uint64_t{1} << turns) - 1;
    trail = static_cast<std::uint64_t>(half.trail) << turns | trail;
    key = {static_cast<std::uint64_t>(half.key) << turns | (key.window & below), half.prefix};
  }
};

}  // namespace accel
