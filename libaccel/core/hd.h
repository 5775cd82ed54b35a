// Function qualifiers that differ between host and device compilers, and the library's assertion.
//
// This header, the SIMD files (*_simd*), geometry/watertight.h and trace/box_pair.h are the only places with `#if`.
#pragma once

#include <cassert>

// A function that runs on the host and, when a CUDA compiler reads it, on the device. Where sanitizers look on, nothing is
// forced inline: the checks around every access make such code twice as long to compile, and the stack of an error names fewer
// functions.
#if defined(__CUDACC__)
#define ACCEL_HD __host__ __device__ __forceinline__
#elif defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define ACCEL_HD inline
#else
#define ACCEL_HD inline __attribute__((always_inline))
#endif

// Behind the captures of a lambda that Primitives::for_each may run on a device (exec/cuda/cuda_primitives.cuh). CUDA compilers
// need leave for it, --extended-lambda, without which such code is for the host only.
#if defined(__CUDACC_EXTENDED_LAMBDA__)
#define ACCEL_HD_LAMBDA __host__ __device__
#else
#define ACCEL_HD_LAMBDA
#endif

// A copy of 16 (8) bytes that no one writes while rays are traced: one load through a device's read-only path, however few of
// the bytes are used; a plain copy on the host.
template <class T>
ACCEL_HD T load_16_bytes(const T& object) {
  static_assert(sizeof(T) == 16 && alignof(T) == 16);
#if defined(__CUDA_ARCH__)
  return __builtin_bit_cast(T, __ldg(reinterpret_cast<const uint4*>(&object)));
#else
  return object;
#endif
}
template <class T>
ACCEL_HD T load_8_bytes(const T& object) {
  static_assert(sizeof(T) == 8 && alignof(T) == 8);
#if defined(__CUDA_ARCH__)
  return __builtin_bit_cast(T, __ldg(reinterpret_cast<const uint2*>(&object)));
#else
  return object;
#endif
}

// Whether this code is compiled for a device, where what is indexed at run time leaves the registers.
ACCEL_HD constexpr bool is_device_code() {
#if defined(__CUDA_ARCH__)
  return true;
#else
  return false;
#endif
}

// One of three by a run-time index: a load on the host, selects on devices.
template <class T>
ACCEL_HD T element_of_three(const T (&three)[3], int i) {
  return !is_device_code() ? three[i] : i == 0 ? three[0] : i == 1 ? three[1] : three[2];
}

// Checks an invariant of the library itself in debug builds. Never used for input: input errors return a Result.
#define ACCEL_ASSERT(condition) assert(condition)
