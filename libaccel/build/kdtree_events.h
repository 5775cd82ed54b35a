// What a kd-tree builder knows about a node that is not split yet: its references, and for each axis the sorted list of the
// planes between which they lie.
//
// Wald and Havran 2006, "On building fast kd-trees for ray tracing, and on doing that in O(N log N)", section 4.2. Deviations:
// one list for each axis; no planar events, for padded triangles are never flat; no events for the ends of references that
// reach to the cell's border, since no plane is worth trying there.
//
// Events are in order of position, ends before starts, then of their references' indices in the node: there are no equal ones,
// so the order of a list is a property of the set.
#pragma once

#include <cstdint>

#include "libaccel/build/references.h"

namespace accel {

struct KdEvent {
  static constexpr std::uint32_t kStart = 1u << 31;  // else the end
  static constexpr std::uint32_t kReference = kStart - 1;

  float position;      // no NaN; zeros are positive
  std::uint32_t word;  // kind and reference

  bool is_start() const { return (word & kStart) != 0; }
  std::uint32_t reference() const { return word & kReference; }
  friend bool operator==(const KdEvent&, const KdEvent&) = default;
  friend bool operator<(const KdEvent& a, const KdEvent& b) {
    return a.position < b.position || (a.position == b.position && a.word < b.word);
  }
};
static_assert(sizeof(KdEvent) == 8);

// The sorted events of one axis.
struct KdEventList {
  KdEvent* events = nullptr;
  std::uint32_t size = 0;
  std::uint32_t starts = 0;  // of them

  std::uint32_t ends() const { return size - starts; }

  // The events of a reference whose padded box reaches from lo to hi, in a cell from cell_lo to cell_hi.
  void append(float lo, float hi, float cell_lo, float cell_hi, std::uint32_t reference) {
    if (lo > cell_lo) events[size++] = {lo + 0.0f, reference | KdEvent::kStart}, ++starts;
    if (hi < cell_hi) events[size++] = {hi + 0.0f, reference};
  }
  // The same for a sorted list, which stays sorted: O(size).
  void insert(float lo, float hi, float cell_lo, float cell_hi, std::uint32_t reference) {
    if (lo > cell_lo) insert({lo + 0.0f, reference | KdEvent::kStart}), ++starts;
    if (hi < cell_hi) insert({hi + 0.0f, reference});
  }

 private:
  void insert(KdEvent event) {
    std::uint32_t at = size++;
    for (; at > 0 && event < events[at - 1]; --at) events[at] = events[at - 1];
    events[at] = event;
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
