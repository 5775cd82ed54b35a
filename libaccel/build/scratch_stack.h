// Memory of a recursion: arrays of plain values that are given up in the reverse order of their allocation, all those behind a
// mark at once.
//
// Blocks grow geometrically and are kept until the stack is destroyed; the meter is told of them. Elements are not initialised.
#pragma once

#include <algorithm>
#include <cstddef>
#include <type_traits>
#include <vector>

#include "libaccel/build/build_context.h"
#include "libaccel/core/buffer.h"

namespace accel {

class ScratchStack {
 public:
  explicit ScratchStack(MemoryMeter& meter) : meter_(&meter) {}
  ScratchStack(ScratchStack&&) = default;
  ScratchStack& operator=(ScratchStack&&) = delete;
  ~ScratchStack() {
    for (const Buffer<std::byte>& block : blocks_) meter_->subtract(block.size_bytes());
  }

  struct Mark {
    std::size_t block, offset;
  };
  Mark mark() const { return {block_, offset_}; }
  MemoryMeter& meter() const { return *meter_; }
  // Gives up all that was allocated since the mark was made.
  void release(Mark mark) { block_ = mark.block, offset_ = mark.offset; }

  template <class T>
  T* allocate(std::size_t count) {
    static_assert(std::is_trivially_copyable_v<T> && alignof(T) <= kAlignment);
    const std::size_t bytes = (count * sizeof(T) + kAlignment - 1) / kAlignment * kAlignment;
    while (block_ >= blocks_.size() || blocks_[block_].size() - offset_ < bytes) next_block(bytes);
    std::byte* const at = blocks_[block_].data() + offset_;
    offset_ += bytes;
    return reinterpret_cast<T*>(at);
  }

 private:
  static constexpr std::size_t kAlignment = 64, kSmallestBlock = 1 << 16;

  void next_block(std::size_t bytes) {
    if (block_ < blocks_.size()) ++block_;
    offset_ = 0;
    if (block_ < blocks_.size()) return;
    const std::size_t grown = blocks_.empty() ? kSmallestBlock : 2 * blocks_.back().size();
    blocks_.emplace_back(std::max(grown, bytes));
    meter_->add(blocks_.back().size_bytes());
  }

  MemoryMeter* meter_;
  std::vector<Buffer<std::byte>> blocks_;
  std::size_t block_ = 0, offset_ = 0;  // of the next allocation
};

}  // namespace accel
