// Device memory with an owner, and calls of the CUDA run-time with their errors checked.
#pragma once

#include <cuda_runtime.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <utility>

#include "libaccel/core/result.h"

namespace accel::cuda {

// The error of a call that failed. The run-time forgets it, or the next launch would report it as its own.
inline Error cuda_error(cudaError_t code, const char* call) {
  cudaGetLastError();
  return Error{"CUDA: " + std::string(cudaGetErrorString(code)) + " (" + cudaGetErrorName(code) + ") in " + call};
}

// Returns from the enclosing function, which returns a Result, when a call of the run-time fails.
#define ACCEL_CUDA_TRY(call)                                                                                                   \
  do {                                                                                                                         \
    if (const cudaError_t accel_code = (call); accel_code != cudaSuccess) return ::accel::cuda::cuda_error(accel_code, #call); \
  } while (false)

// Memory that lasts: allocations may wait for the device, and so do releases.
struct LastingMemory {
  static cudaError_t allocate(void** data, std::size_t bytes) { return cudaMalloc(data, bytes); }
  static void release(void* data) { cudaFree(data); }
};

// Memory for results in between: allocated and released in the order of the work in the default stream, without waiting.
struct ScratchMemory {
  static cudaError_t allocate(void** data, std::size_t bytes) { return cudaMallocAsync(data, bytes, nullptr); }
  static void release(void* data) { cudaFreeAsync(data, nullptr); }
};

// An array on the device. Elements are not initialised.
template <class T, class Memory = LastingMemory>
class DeviceArray {
 public:
  DeviceArray() = default;
  DeviceArray(DeviceArray&& other) noexcept { swap(other); }
  DeviceArray& operator=(DeviceArray&& other) noexcept {
    swap(other);
    return *this;
  }
  ~DeviceArray() {
    if (data_ != nullptr) Memory::release(data_);
  }

  static Result<DeviceArray> allocate(std::size_t size) {
    Result<DeviceArray> array = DeviceArray();
    if (size == 0) return array;
    void* data = nullptr;
    ACCEL_CUDA_TRY(Memory::allocate(&data, size * sizeof(T)));
    array->data_ = static_cast<T*>(data), array->size_ = size;
    return array;
  }

  static Result<DeviceArray> copy_of(std::span<const T> values) {
    Result<DeviceArray> array = allocate(values.size());
    if (!array || values.empty()) return array;
    ACCEL_CUDA_TRY(cudaMemcpy(array->data_, values.data(), values.size_bytes(), cudaMemcpyHostToDevice));
    return array;
  }

  // In the order of the work in the default stream, without waiting.
  Status fill_bytes(std::uint8_t byte) {
    if (size_ != 0) ACCEL_CUDA_TRY(cudaMemsetAsync(data_, byte, size_ * sizeof(T)));
    return Done{};
  }

  // Copies all elements to the host; the span has this array's size.
  Status copy_to(std::span<T> values) const {
    if (values.size() != size_) {
      return Error{"there are " + std::to_string(size_) + " results on the device, but room for " +
                   std::to_string(values.size())};
    }
    if (size_ != 0) ACCEL_CUDA_TRY(cudaMemcpy(values.data(), data_, values.size_bytes(), cudaMemcpyDeviceToHost));
    return Done{};
  }

  T* data() { return data_; }
  const T* data() const { return data_; }
  std::size_t size() const { return size_; }

 private:
  void swap(DeviceArray& other) { std::swap(data_, other.data_), std::swap(size_, other.size_); }

  T* data_ = nullptr;
  std::size_t size_ = 0;
};

// While it lives, the device keeps scratch memory that is released for the next allocations, instead of giving it back whenever
// the host waits for the device.
class ScratchMemoryScope {
 public:
  ScratchMemoryScope() = default;
  ScratchMemoryScope(const ScratchMemoryScope&) = delete;
  ScratchMemoryScope& operator=(const ScratchMemoryScope&) = delete;
  ~ScratchMemoryScope() {
    if (pool_ == nullptr) return;
    cudaMemPoolSetAttribute(pool_, cudaMemPoolAttrReleaseThreshold, &threshold_before_);
    cudaStreamSynchronize(nullptr);
    cudaMemPoolTrimTo(pool_, threshold_before_);
  }

  Status begin() {
    int device = 0;
    cudaMemPool_t pool = nullptr;
    ACCEL_CUDA_TRY(cudaGetDevice(&device));
    ACCEL_CUDA_TRY(cudaDeviceGetDefaultMemPool(&pool, device));
    ACCEL_CUDA_TRY(cudaMemPoolGetAttribute(pool, cudaMemPoolAttrReleaseThreshold, &threshold_before_));
    std::uint64_t all = std::numeric_limits<std::uint64_t>::max();
    ACCEL_CUDA_TRY(cudaMemPoolSetAttribute(pool, cudaMemPoolAttrReleaseThreshold, &all));
    pool_ = pool;
    return Done{};
  }

 private:
  cudaMemPool_t pool_ = nullptr;
  std::uint64_t threshold_before_ = 0;
};

// A point in the device's time.
class DeviceEvent {
 public:
  DeviceEvent() = default;
  DeviceEvent(const DeviceEvent&) = delete;
  DeviceEvent& operator=(const DeviceEvent&) = delete;
  ~DeviceEvent() {
    if (event_ != nullptr) cudaEventDestroy(event_);
  }

  Status record() {
    if (event_ == nullptr) ACCEL_CUDA_TRY(cudaEventCreate(&event_));
    ACCEL_CUDA_TRY(cudaEventRecord(event_));
    return Done{};
  }

  // Waits for this event.
  Result<float> milliseconds_since(const DeviceEvent& start) const {
    float elapsed = 0;
    ACCEL_CUDA_TRY(cudaEventSynchronize(event_));
    ACCEL_CUDA_TRY(cudaEventElapsedTime(&elapsed, start.event_, event_));
    return elapsed;
  }

 private:
  cudaEvent_t event_ = nullptr;
};

}  // namespace accel::cuda
