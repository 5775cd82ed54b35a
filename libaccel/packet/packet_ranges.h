// Cuts a sequence of rays into packets: Garanzha and Loop 2010 [GL10], section 3.1, "Decomposition: packet ranges extraction",
// Fig. 6.
//
// Runs of equal keys (hash values, or faces: see packet/frustum.h) are cut into packets of max_size rays; the last one of a run
// has what is left.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "libaccel/packet/csd_sort.h"
#include "libaccel/packet/frustum.h"

namespace accel {

template <class Primitives>
struct PacketRanges {
  typename Primitives::template Array<std::uint32_t> base;  // of count + 1: where packets begin, and the end of the last one
  std::size_t count = 0;
};

// Of n < 2^32 keys. O(n).
template <class Primitives, class Key>
PacketRanges<Primitives> packet_ranges(const Key* keys, std::size_t n, std::uint32_t max_size) {
  using Indices = typename Primitives::template Array<std::uint32_t>;
  const auto chunks = detail::compress<Primitives, Key>(keys, n);
  const std::size_t chunk_count = chunks.count;
  const std::uint32_t* const base = chunks.base.data();

  // Where the packets of each chunk begin among all packets.
  Indices firsts(chunk_count);
  std::uint32_t* const first = firsts.data();
  Primitives::for_each(chunk_count, [=] ACCEL_HD_LAMBDA(std::size_t c) {
    const std::uint32_t end = c + 1 < chunk_count ? base[c + 1] : static_cast<std::uint32_t>(n);
    first[c] = (end - base[c] + max_size - 1) / max_size;
  });
  PacketRanges<Primitives> ranges;
  ranges.count = Primitives::exclusive_scan(first, chunk_count, first);

  // Every packet begins max_size rays after the one before, unless it is the first of its chunk.
  ranges.base = Indices(ranges.count + 1);
  typename Primitives::template Array<std::uint8_t> heads(ranges.count);
  std::uint32_t* const skeleton = ranges.base.data();
  std::uint8_t* const is_head = heads.data();
  const std::size_t count = ranges.count;
  Primitives::for_each(count, [=] ACCEL_HD_LAMBDA(std::size_t p) { skeleton[p] = max_size, is_head[p] = 0; });
  Primitives::for_each(chunk_count,
                       [=] ACCEL_HD_LAMBDA(std::size_t c) { skeleton[first[c]] = base[c], is_head[first[c]] = 1; });
  Primitives::inclusive_segmented_scan(skeleton, is_head, count, skeleton);
  Primitives::for_each(1, [=] ACCEL_HD_LAMBDA(std::size_t) { skeleton[count] = static_cast<std::uint32_t>(n); });
  return ranges;
}

// packet_ranges() of faces (packet/frustum.h) that ascend, on hosts: O(packets + log n).
template <class Primitives>
PacketRanges<Primitives> ranges_of_faces(std::span<const std::uint8_t> faces, std::uint32_t max_size) {
  const auto end_of = [&](std::uint32_t face) {
    return static_cast<std::uint32_t>(std::upper_bound(faces.begin(), faces.end(), face) - faces.begin());
  };
  PacketRanges<Primitives> ranges;
  for (std::uint32_t face = 0, first = 0, end; face <= kNoFace; first = end, ++face)
    ranges.count += ((end = end_of(face)) - first + max_size - 1) / max_size;
  ranges.base = typename Primitives::template Array<std::uint32_t>(ranges.count + 1);
  std::uint32_t* base = ranges.base.data();
  for (std::uint32_t face = 0, first = 0, end; face <= kNoFace; ++face)
    for (end = end_of(face); first < end; first += std::min(max_size, end - first)) *base++ = first;
  *base = static_cast<std::uint32_t>(faces.size());
  return ranges;
}

}  // namespace accel
