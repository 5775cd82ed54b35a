// The parallel primitives of packet/cpu_primitives.h on a CUDA device: the same functions, of arrays in the device's memory, on
// CUB. What a pipeline's templates write there is what they write on the CPU.
//
// Bodies of for_each are function objects that are copied to the device: lambdas capture by value and are marked
// ACCEL_HD_LAMBDA (core/hd.h), and nothing that they or their callers are made of is private (a restriction of CUDA's extended
// lambdas). All work is in the default stream. Functions that return a number wait for it, the others for nothing.
//
// Errors. Pipelines are written for primitives that may throw, as CpuPrimitives do when memory is short; so do these, when a
// call of the run-time fails, and caught() makes a Status of it. Whoever runs a pipeline on the device does so within caught():
// the exception's type has no other handler, and none leaves the library.
#pragma once

#include <thrust/iterator/counting_iterator.h>
#include <thrust/iterator/transform_iterator.h>
#include <thrust/iterator/transform_output_iterator.h>
#include <cub/device/device_radix_sort.cuh>
#include <cub/device/device_reduce.cuh>
#include <cub/device/device_scan.cuh>
#include <cub/device/device_select.cuh>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <new>
#include <type_traits>
#include <utility>

#include "libaccel/core/hd.h"
#include "libaccel/core/result.h"
#include "libaccel/exec/cuda/device_memory.cuh"

namespace accel::cuda {

// What the primitives throw.
struct DeviceFailure {
  Error error;
};

inline void throw_unless_done(cudaError_t code, const char* call) {
  if (code != cudaSuccess) throw DeviceFailure{cuda_error(code, call)};
}

// Runs body() and turns what it throws into an error.
template <class Body>
Status caught(const Body& body) {
  try {
    body();
    return Done{};
  } catch (const DeviceFailure& failure) {
    return failure.error;
  } catch (const std::bad_alloc&) {
    return Error{"out of memory"};
  }
}

// DeviceArray with the constructors of Buffer.
template <class T>
class ScratchArray {
  static_assert(std::is_trivially_copyable_v<T>, "arrays are copied to and from devices as bytes");

 public:
  ScratchArray() = default;
  explicit ScratchArray(std::size_t size) {
    auto array = DeviceArray<T, ScratchMemory>::allocate(size);
    if (!array) throw DeviceFailure{array.error()};
    array_ = std::move(*array);
  }

  T* data() { return array_.data(); }
  const T* data() const { return array_.data(); }
  std::size_t size() const { return array_.size(); }

 private:
  DeviceArray<T, ScratchMemory> array_;
};

namespace detail {

struct Sum {
  template <class T>
  ACCEL_HD T operator()(T a, const T& b) const {
    return a += b;
  }
};

struct BitOr {
  template <class T>
  ACCEL_HD T operator()(const T& a, const T& b) const {
    return a | b;
  }
};

// The values from one place to another: their sum from the last head on, and whether there is a head. Segments that follow each
// other add up to one (Blelloch 1990, "Prefix Sums and Their Applications", section 1.5).
template <class T>
struct Segment {
  T sum;
  bool has_head;
};
struct JoinSegments {
  template <class T>
  ACCEL_HD Segment<T> operator()(const Segment<T>& left, const Segment<T>& right) const {
    return {right.has_head ? right.sum : Sum{}(left.sum, right.sum), left.has_head || right.has_head};
  }
};
template <class T>
struct SegmentAt {
  const T* values;
  const std::uint8_t* heads;
  ACCEL_HD Segment<T> operator()(std::uint32_t i) const { return {values[i], heads[i] != 0}; }
};
struct SumOfSegment {
  template <class T>
  ACCEL_HD T operator()(const Segment<T>& segment) const {
    return segment.sum;
  }
};

template <class Key>
struct DifferenceFromFirst {
  const Key* keys;
  ACCEL_HD Key operator()(std::uint32_t i) const { return keys[i] ^ keys[0]; }
};

// One thread an index. Deviation: cub::DeviceFor would give each thread two, with the body inlined twice, for which the bodies
// that intersect rays have too few registers.
inline constexpr unsigned kForEachBlock = 128;
template <class Body>
__global__ void __launch_bounds__(kForEachBlock) for_each_kernel(const std::size_t n, const Body body) {
  const std::size_t i = std::size_t{blockIdx.x} * kForEachBlock + threadIdx.x;
  if (i < n) body(i);
}

}  // namespace detail

struct CudaPrimitives {
  template <class T>
  using Array = ScratchArray<T>;

  // body(i) for each i below n, concurrently: a warp's threads have consecutive i, from a multiple of 32 on.
  template <class Body>
  static void for_each(std::size_t n, const Body& body) {
    if (n == 0) return;
    const auto blocks = static_cast<unsigned>((n + detail::kForEachBlock - 1) / detail::kForEachBlock);
    detail::for_each_kernel<<<blocks, detail::kForEachBlock>>>(n, body);
    throw_unless_done(cudaGetLastError(), "for_each");
  }

  template <class T>
  static T exclusive_scan(const T* in, std::size_t n, T* out) {
    if (n == 0) return T{};
    // The total is the last sum and the last value, which is gone afterwards where `out` is `in`.
    Array<T> ends(2);
    copy(in + n - 1, 1, ends.data());
    with_storage("cub::DeviceScan::ExclusiveScan", [&](void* storage, std::size_t& bytes) {
      return cub::DeviceScan::ExclusiveScan(storage, bytes, in, out, detail::Sum{}, T{}, static_cast<std::uint32_t>(n));
    });
    copy(out + n - 1, 1, ends.data() + 1);
    T last[2];
    read(ends.data(), 2, last);
    return detail::Sum{}(last[1], last[0]);
  }

  // CUB scans tile by tile, and a tile is read before any of it is written, so that `out` may be `in` here, too.
  template <class T>
  static void inclusive_segmented_scan(const T* in, const std::uint8_t* heads, std::size_t n, T* out) {
    if (n == 0) return;
    const auto segments = thrust::make_transform_iterator(first_index(), detail::SegmentAt<T>{in, heads});
    const auto sums = thrust::make_transform_output_iterator(out, detail::SumOfSegment{});
    with_storage("cub::DeviceScan::InclusiveScan", [&](void* storage, std::size_t& bytes) {
      return cub::DeviceScan::InclusiveScan(storage, bytes, segments, sums, detail::JoinSegments{},
                                            static_cast<std::uint32_t>(n));
    });
  }

  static std::size_t compact(const std::uint8_t* flags, std::size_t n, std::uint32_t* out) {
    if (n == 0) return 0;
    Array<std::uint32_t> count(1);
    with_storage("cub::DeviceSelect::Flagged", [&](void* storage, std::size_t& bytes) {
      return cub::DeviceSelect::Flagged(storage, bytes, first_index(), flags, out, count.data(), static_cast<std::int64_t>(n));
    });
    return value_of(count);
  }

  template <class Key>
  static void sort_pairs(Key* keys, std::uint32_t* values, std::size_t n) {
    static_assert(std::is_unsigned_v<Key>);
    if (n < 2) return;
    const Key differing = differing_bits(keys, n);
    if (differing == 0) return;
    Array<Key> other_keys(n);
    Array<std::uint32_t> other_values(n);
    cub::DoubleBuffer<Key> both_keys(keys, other_keys.data());
    cub::DoubleBuffer<std::uint32_t> both_values(values, other_values.data());
    with_storage("cub::DeviceRadixSort::SortPairs", [&](void* storage, std::size_t& bytes) {
      return cub::DeviceRadixSort::SortPairs(storage, bytes, both_keys, both_values, static_cast<std::uint32_t>(n),
                                             std::countr_zero(differing), std::bit_width(differing));
    });
    if (both_keys.Current() != keys) copy(both_keys.Current(), n, keys);
    if (both_values.Current() != values) copy(both_values.Current(), n, values);
  }

 private:
  static thrust::counting_iterator<std::uint32_t> first_index() { return thrust::counting_iterator<std::uint32_t>(0); }

  // Calls a function of CUB twice: for the size of its temporary storage, and with it.
  template <class Call>
  static void with_storage(const char* name, const Call& call) {
    std::size_t bytes = 0;
    throw_unless_done(call(nullptr, bytes), name);
    Array<std::byte> storage(bytes > 0 ? bytes : 1);
    throw_unless_done(call(storage.data(), bytes), name);
  }

  // The bits in which any key differs from the first.
  template <class Key>
  static Key differing_bits(const Key* keys, std::size_t n) {
    const auto differences = thrust::make_transform_iterator(first_index(), detail::DifferenceFromFirst<Key>{keys});
    Array<Key> all(1);
    with_storage("cub::DeviceReduce::Reduce", [&](void* storage, std::size_t& bytes) {
      return cub::DeviceReduce::Reduce(storage, bytes, differences, all.data(), static_cast<std::uint32_t>(n), detail::BitOr{},
                                       Key{0});
    });
    return value_of(all);
  }

  template <class T>
  static void copy(const T* from, std::size_t n, T* to) {
    throw_unless_done(cudaMemcpyAsync(to, from, n * sizeof(T), cudaMemcpyDeviceToDevice), "cudaMemcpyAsync");
  }
  template <class T>
  static void read(const T* from, std::size_t n, T* to) {
    throw_unless_done(cudaMemcpy(to, from, n * sizeof(T), cudaMemcpyDeviceToHost), "cudaMemcpy");
  }
  template <class T>
  static T value_of(const Array<T>& one) {
    T value;
    read(one.data(), 1, &value);
    return value;
  }
};

}  // namespace accel::cuda
