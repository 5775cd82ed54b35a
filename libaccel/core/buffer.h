// A fixed-size array of plain values, aligned for SIMD loads and cache lines, that it owns or that it borrows from a mapped
// file.
//
// Copies share the storage (as std::shared_ptr does): what is written to one is read from all. The storage lives as long as the
// last copy. Elements of an owning buffer are not initialised: builders fill them. A buffer that has been moved from is empty.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <span>
#include <type_traits>
#include <utility>

#include "libaccel/core/hd.h"

namespace accel {

namespace detail {

// Memory of a buffer. Large ones begin at a page of two megabytes and ask for such pages, which random accesses miss less often
// in the tables of translations: random rays are 3 to 9 % faster in trees of 60 MB. May throw std::bad_alloc.
void* allocate_buffer(std::size_t bytes);
void free_buffer(void* memory, std::size_t bytes);

}  // namespace detail

// The alignment of every buffer, in bytes: a line of a GPU's cache, two of a CPU's, and two two-box nodes. The SIMT model
// counts lines by address, so figures would depend on the allocator if it were less.
inline constexpr std::size_t kBufferAlignment = 128;

template <class T>
class Buffer {
  static_assert(std::is_trivially_copyable_v<T>, "buffers are written to files and copied to devices as bytes");

 public:
  Buffer() = default;
  Buffer(const Buffer&) = default;
  Buffer& operator=(const Buffer&) = default;
  Buffer(Buffer&& other) noexcept
      : data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0)), storage_(std::move(other.storage_)) {}
  Buffer& operator=(Buffer&& other) noexcept {
    Buffer taken(std::move(other));
    std::swap(data_, taken.data_), std::swap(size_, taken.size_), std::swap(storage_, taken.storage_);
    return *this;
  }

  // `size` uninitialised elements. Throws std::bad_alloc: functions of the library that make buffers return an Error then.
  explicit Buffer(std::size_t size) : size_(size) {
    if (size == 0) return;
    if (size > PTRDIFF_MAX / sizeof(T)) throw std::bad_array_new_length();
    const std::size_t bytes = size * sizeof(T);
    storage_ = std::shared_ptr<void>(detail::allocate_buffer(bytes), [bytes](void* p) { detail::free_buffer(p, bytes); });
    data_ = static_cast<T*>(storage_.get());
  }

  // Borrows `size` elements at `data`, which `keep_alive` owns (a mapped file, or the caller's container); it is null where the
  // memory outlives all copies.
  Buffer(T* data, std::size_t size, std::shared_ptr<void> keep_alive)
      : data_(data), size_(size), storage_(std::move(keep_alive)) {}

  // A copy of a range.
  static Buffer copy_of(std::span<const T> values) {
    Buffer result(values.size());
    for (std::size_t i = 0; i < values.size(); ++i) result[i] = values[i];
    return result;
  }

  T* data() { return data_; }
  const T* data() const { return data_; }
  std::size_t size() const { return size_; }
  std::size_t size_bytes() const { return size_ * sizeof(T); }
  bool empty() const { return size_ == 0; }

  T& operator[](std::size_t i) { return ACCEL_ASSERT(i < size_), data_[i]; }
  const T& operator[](std::size_t i) const { return ACCEL_ASSERT(i < size_), data_[i]; }

  T* begin() { return data_; }
  T* end() { return data_ + size_; }
  const T* begin() const { return data_; }
  const T* end() const { return data_ + size_; }

  std::span<const T> span() const { return {data_, size_}; }
  std::span<T> span() { return {data_, size_}; }

  // `size` elements from `first` on, which share the storage.
  Buffer part(std::size_t first, std::size_t size) const {
    ACCEL_ASSERT(first <= size_ && size <= size_ - first);
    return Buffer(data_ + first, size, storage_);
  }

  // Gives up the elements from `size` on; the storage is kept.
  void truncate(std::size_t size) { size_ = size < size_ ? size : size_; }

 private:
  T* data_ = nullptr;
  std::size_t size_ = 0;
  std::shared_ptr<void> storage_;
};

}  // namespace accel
