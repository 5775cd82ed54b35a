// Structures on the device: their arrays are copied, and their view is made to point to the copies.
//
// A new structure needs one overload of upload(), which lists its arrays.
#pragma once

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "libaccel/core/buffer.h"
#include "libaccel/exec/cuda/device_memory.cuh"
#include "libaccel/structure/bvh2.h"
#include "libaccel/structure/kdtree.h"
#include "libaccel/structure/triangle_list.h"

namespace accel::cuda {

// Copies arrays and keeps the copies. The first error stays; copies after it are not made.
class Uploader {
 public:
  template <class T>
  const T* copy(const Buffer<T>& buffer) {
    if (error_) return nullptr;
    auto array = DeviceArray<T>::copy_of(buffer.span());
    if (!array) {
      error_ = array.error();
      return nullptr;
    }
    auto kept = std::make_shared<DeviceArray<T>>(std::move(*array));
    bytes_ += buffer.size_bytes();
    copies_.push_back(kept);
    return kept->data();
  }

  Status status() const { return error_ ? Status(*error_) : Status(Done{}); }
  std::size_t bytes() const { return bytes_; }
  std::vector<std::shared_ptr<const void>> take_copies() { return std::move(copies_); }

 private:
  std::optional<Error> error_;
  std::size_t bytes_ = 0;
  std::vector<std::shared_ptr<const void>> copies_;
};

inline Bvh2View upload(const Bvh2& bvh, Uploader& device) {
  return {device.copy(bvh.nodes), device.copy(bvh.leaves), bvh.root};
}

inline KdTreeView upload(const KdTree& tree, Uploader& device) {
  return {device.copy(tree.nodes),
          {device.copy(tree.leaves.triangles), device.copy(tree.leaves.references)},
          tree.bounds,
          device.copy(tree.parents),
          device.copy(tree.cells),
          device.copy(tree.ropes)};
}

inline TriangleListView upload(const TriangleList& list, Uploader& device) { return {device.copy(list.leaves)}; }

}  // namespace accel::cuda
