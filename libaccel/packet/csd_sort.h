// Sorts rays by their hash values: compression, sorting, decompression. Garanzha and Loop 2010 [GL10], section 3.1, Fig. 3
// to 5.
//
// Rays that come one after the other often have the same value. Runs of equal values are sorted as one, and then written out:
// the sort moves chunks instead of rays. The result is that of a stable sort of all rays.
#pragma once

#include <cstdint>

#include "libaccel/core/hd.h"
#include "libaccel/packet/stage_clock.h"

namespace accel {

template <class Primitives>
struct CsdOrder {
  typename Primitives::template Array<std::uint32_t> ids;  // ids[i]: the ray that comes i-th
  std::size_t chunks = 0;                                  // runs of equal values
};

namespace detail {

// [GL10] Fig. 4.
template <class Primitives, class Key>
struct Chunks {
  template <class T>
  using Array = typename Primitives::template Array<T>;

  Array<Key> hash;
  Array<std::uint32_t> base;  // the first ray; has room for all
  std::size_t count = 0;
};

template <class Primitives, class Key>
Chunks<Primitives, Key> compress(const Key* values, std::size_t n) {
  Chunks<Primitives, Key> chunks;
  typename Primitives::template Array<std::uint8_t> heads(n);
  std::uint8_t* const is_head = heads.data();
  Primitives::for_each(n, [=] ACCEL_HD_LAMBDA(std::size_t i) { is_head[i] = i == 0 || values[i] != values[i - 1]; });
  chunks.base = typename Primitives::template Array<std::uint32_t>(n);
  chunks.count = Primitives::compact(is_head, n, chunks.base.data());
  chunks.hash = typename Primitives::template Array<Key>(chunks.count);
  Key* const hash = chunks.hash.data();
  const std::uint32_t* const base = chunks.base.data();
  Primitives::for_each(chunks.count, [=] ACCEL_HD_LAMBDA(std::size_t c) { hash[c] = values[base[c]]; });
  return chunks;
}

// [GL10] Fig. 5: `order` has the chunks as they come after the sort.
template <class Primitives>
typename Primitives::template Array<std::uint32_t> decompress(const std::uint32_t* base, const std::uint32_t* order,
                                                              std::size_t chunks, std::size_t n) {
  typename Primitives::template Array<std::uint32_t> starts(chunks), skeleton(n);
  typename Primitives::template Array<std::uint8_t> heads(n);
  std::uint32_t *const start = starts.data(), *const ids = skeleton.data();
  std::uint8_t* const is_head = heads.data();
  Primitives::for_each(chunks, [=] ACCEL_HD_LAMBDA(std::size_t c) {
    const std::uint32_t chunk = order[c];
    start[c] = (chunk + 1 < chunks ? base[chunk + 1] : static_cast<std::uint32_t>(n)) - base[chunk];
  });
  Primitives::exclusive_scan(start, chunks, start);
  Primitives::for_each(n, [=] ACCEL_HD_LAMBDA(std::size_t i) { ids[i] = 1, is_head[i] = 0; });
  Primitives::for_each(chunks, [=] ACCEL_HD_LAMBDA(std::size_t c) { ids[start[c]] = base[order[c]], is_head[start[c]] = 1; });
  Primitives::inclusive_segmented_scan(ids, is_head, n, ids);
  return skeleton;
}

}  // namespace detail

// The same order by a sort of all rays, one by one, which leaves the values sorted.
template <class Primitives, class Key>
typename Primitives::template Array<std::uint32_t> plain_sort(Key* values, std::size_t n) {
  typename Primitives::template Array<std::uint32_t> order(n);
  std::uint32_t* const ids = order.data();
  Primitives::for_each(n, [=] ACCEL_HD_LAMBDA(std::size_t i) { ids[i] = static_cast<std::uint32_t>(i); });
  Primitives::sort_pairs(values, ids, n);
  return order;
}

// Of fewer than 2^32 values. The clock gets a lap after each of the three stages. O(n); the memory besides the result is 5
// bytes a ray and 2 sizeof(Key) + 16 a chunk.
template <class Primitives, class Key, class Clock = NoClock>
CsdOrder<Primitives> csd_sort(const Key* values, std::size_t n, Clock&& clock = Clock{}) {
  auto chunks = detail::compress<Primitives, Key>(values, n);
  clock.lap(PacketStage::compress);
  const auto order = plain_sort<Primitives>(chunks.hash.data(), chunks.count);
  clock.lap(PacketStage::sort);
  CsdOrder<Primitives> sorted{detail::decompress<Primitives>(chunks.base.data(), order.data(), chunks.count, n), chunks.count};
  clock.lap(PacketStage::decompress);
  return sorted;
}

}  // namespace accel
