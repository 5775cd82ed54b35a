// Structures on the device: their arrays are copied, and their view is made to point to the copies.
//
// The arrays are those that a structure lists (structure/arrays.h): there is nothing to add here for a new one.
#pragma once

#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "libaccel/core/buffer.h"
#include "libaccel/exec/cuda/device_memory.cuh"
#include "libaccel/structure/arrays.h"

namespace accel::cuda {

// Copies arrays and keeps the copies. The first error stays; copies after it are not made.
class Uploader {
 public:
  // A buffer that borrows the copy on the device; what is in it cannot be read here.
  template <class T>
  Buffer<T> copy(const Buffer<T>& buffer) {
    if (error_) return {};
    auto array = DeviceArray<T>::copy_of(buffer.span());
    if (!array) {
      error_ = array.error();
      return {};
    }
    auto kept = std::make_shared<DeviceArray<T>>(std::move(*array));
    bytes_ += buffer.size_bytes();
    copies_.push_back(kept);
    return Buffer<T>(kept->data(), kept->size(), kept);
  }

  Status status() const { return error_ ? Status(*error_) : Status(Done{}); }
  std::size_t bytes() const { return bytes_; }
  std::vector<std::shared_ptr<const void>> take_copies() { return std::move(copies_); }

 private:
  std::optional<Error> error_;
  std::size_t bytes_ = 0;
  std::vector<std::shared_ptr<const void>> copies_;
};

// The view of the structure's copy on the device.
template <StructureOfArrays Structure>
typename Structure::View upload(Structure structure, Uploader& device) {
  Structure::for_each_array(structure, [&](std::string_view, auto& array) { array = device.copy(array); });
  return structure.view();
}

}  // namespace accel::cuda
