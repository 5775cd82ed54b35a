// The packets of rays in some order, and what their frustums meet: what goes from stage to stage of a batch pipeline. Garanzha
// and Loop 2010 [GL10], Fig. 1.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "libaccel/packet/breadth_first.h"
#include "libaccel/packet/localized.h"
#include "libaccel/packet/packet_ranges.h"

namespace accel {

// All functions may throw std::bad_alloc.
template <class Primitives>
class PacketSet {
 public:
  // Cuts n rays, in their order, where keys change, and after max_size rays. Packets of fewer than min_size rays, and those
  // whose rays have no face, take no further part. keys[i] and faces[i] are of the ray that comes i-th.
  template <class Key>
  void cut(const Key* keys, const std::uint8_t* faces, std::size_t n, std::uint32_t max_size, std::uint32_t min_size) {
    ranges_ = packet_ranges<Primitives>(keys, n, max_size);
    choose(faces, min_size);
  }
  // The same where faces are the keys, and ascend.
  void cut_by_face(std::span<const std::uint8_t> faces, std::uint32_t max_size, std::uint32_t min_size) {
    ranges_ = ranges_of_faces<Primitives>(faces, max_size);
    choose(faces.data(), min_size);
  }

  // Packets that take part, by number.
  std::size_t count() const { return packets_.size(); }
  // The rays of the i-th of them.
  std::uint32_t size_of(std::size_t i) const { return size(packets_[i]); }

  // Frustums of the packets, for the caller to make.
  std::vector<Frustum>& frustums() { return frustums_; }
  const std::vector<Frustum>& frustums() const { return frustums_; }

  // The packets that take part, without frustums. rays[ids[i]] is the ray that comes i-th.
  LocalizedBatch batch(const Bvh2View& view, const Ray* rays, const std::uint32_t* ids) const {
    return batch_of(packets_, view, rays, ids);
  }

  // Traverses the tree's octo nodes. budget(i) is the most pairs that frustum i may have in the queue.
  template <class Traversal, class Budget>
  void find_leaves(Traversal& traversal, const Bvh2View& view, const Budget& budget) {
    gave_up_.resize(packets_.size()), budgets_.resize(packets_.size());
    for (std::size_t i = 0; i < packets_.size(); ++i) budgets_[i] = budget(i);
    const FrustumQueue<Primitives>& leaves =
        traversal.run(view, frustums_.data(), frustums_.size(), budgets_.data(), gave_up_.data());
    // The packets whose frustums meet anything: [GL10], end of section 3.3.
    const auto active = detail::compress<Primitives>(leaves.frustum.data(), leaves.count);
    active_.clear(), firsts_.clear(), active_frustums_.clear();
    for (std::size_t a = 0; a < active.count; ++a) {
      active_.push_back(packets_[active.hash[a]]), active_frustums_.push_back(frustums_[active.hash[a]]);
      firsts_.push_back(active.base[a]);
    }
    firsts_.push_back(static_cast<std::uint32_t>(leaves.count));
    places_ = leaves.place.data();
  }

  // The packets that meet anything, with the leaves that they meet; valid until the next traversal.
  LocalizedBatch active(const Bvh2View& view, const Ray* rays, const std::uint32_t* ids) const {
    LocalizedBatch batch = batch_of(active_, view, rays, ids);
    batch.frustums = active_frustums_.data(), batch.firsts = firsts_.data(), batch.places = places_;
    return batch;
  }
  std::size_t leaf_count() const { return firsts_.back(); }

  // body(first, end): rays from `first` on before `end`, in their order, that are in no packet which takes part, or in one
  // whose frustum has given up. Ascending.
  template <class Body>
  void for_each_left(const Body& body) const {
    std::size_t next = 0;
    for (std::uint32_t p = 0; p < ranges_.count; ++p) {
      const bool takes_part = next < packets_.size() && packets_[next] == p;
      const bool gave_up = takes_part && next < gave_up_.size() && gave_up_[next] != 0;
      if (!takes_part || gave_up) body(ranges_.base[p], ranges_.base[p + 1]);
      next += takes_part ? 1 : 0;
    }
  }

 private:
  void choose(const std::uint8_t* faces, std::uint32_t min_size) {
    packets_.clear(), gave_up_.clear();
    for (std::uint32_t p = 0; p < ranges_.count; ++p)
      if (size(p) >= min_size && faces[ranges_.base[p]] != kNoFace) packets_.push_back(p);
    frustums_.resize(packets_.size());
  }

  std::uint32_t size(std::uint32_t p) const { return ranges_.base[p + 1] - ranges_.base[p]; }

  LocalizedBatch batch_of(const std::vector<std::uint32_t>& packets, const Bvh2View& view, const Ray* rays,
                          const std::uint32_t* ids) const {
    return {.nodes = view.octo,
            .leaves = view.leaves,
            .rays = rays,
            .ids = ids,
            .packets = ranges_.base.data(),
            .active = packets.data(),
            .count = packets.size()};
  }

  PacketRanges<Primitives> ranges_;
  std::vector<std::uint32_t> packets_;
  // Of them.
  std::vector<Frustum> frustums_;
  std::vector<std::uint32_t> budgets_;
  std::vector<std::uint8_t> gave_up_;
  // See LocalizedBatch.
  std::vector<std::uint32_t> active_, firsts_;
  std::vector<Frustum> active_frustums_;
  const std::uint32_t* places_ = nullptr;
};

}  // namespace accel
