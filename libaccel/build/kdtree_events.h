// What a kd-tree builder knows about a node that is not split yet: its references, and for each axis the sorted list of the
// planes between which they lie.
//
// Wald and Havran 2006, "On building fast kd-trees for ray tracing, and on doing that in O(N log N)", section 4.2. Deviations:
// one list for each axis; no planar events, for padded triangles are never flat; no events for the ends of references that
// reach to the cell's border, since no plane is worth trying there.
//
// An event is one 64-bit key: position, kind, and the reference's index in the node. Sorted keys are in order of position, ends
// before starts, and there are no equal ones, so the order of a list is a property of the set.
#pragma once

#include <bit>
#include <cstdint>

#include "libaccel/build/references.h"

namespace accel {

using KdEvent = std::uint64_t;
inline constexpr KdEvent kStartOfReference = 1u << 31;  // else its end
inline constexpr KdEvent kEventReference = kStartOfReference - 1;

// Zeros are positive.
inline KdEvent make_event(float position, KdEvent kind, std::uint32_t reference) {
  const auto bits = std::bit_cast<std::uint32_t>(position + 0.0f);
  const std::uint32_t ordered = bits ^ (static_cast<std::uint32_t>(static_cast<std::int32_t>(bits) >> 31) | 0x80000000u);
  return static_cast<KdEvent>(ordered) << 32 | kind | reference;
}
inline float position_of(KdEvent event) {
  const auto ordered = static_cast<std::uint32_t>(event >> 32);
  return std::bit_cast<float>(ordered ^ (static_cast<std::uint32_t>(static_cast<std::int32_t>(~ordered) >> 31) | 0x80000000u));
}
inline bool is_start(KdEvent event) { return (event & kStartOfReference) != 0; }
inline std::uint32_t reference_of(KdEvent event) { return static_cast<std::uint32_t>(event & kEventReference); }

// The sorted events of one axis.
struct KdEventList {
  KdEvent* events = nullptr;
  std::uint32_t size = 0;
  std::uint32_t starts = 0;  // of them

  // The events of a reference whose padded box reaches from lo to hi, in a cell from cell_lo to cell_hi.
  void append(float lo, float hi, float cell_lo, float cell_hi, std::uint32_t reference) {
    if (lo > cell_lo) events[size++] = make_event(lo, kStartOfReference, reference), ++starts;
    if (hi < cell_hi) events[size++] = make_event(hi, 0, reference);
  }
};

// The references of a node: each is the padded box of the part of a triangle that the node's cell has to know, and meets the
// inside of the cell.
struct KdSet {
  Aabb cell;
  Reference* references = nullptr;
  std::uint32_t size = 0;
  KdEventList axis[3];
  std::uint64_t limit = 0;  // references that the leaves below may have
  int levels = 0;           // inner nodes that a path may still have
};

}  // namespace accel
