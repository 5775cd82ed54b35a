// Each primitive on the device against its serial twin, at sizes around those of warps and of CUB's tiles. Skipped where there
// is no device, but for what runs on the host.
#include "libaccel/exec/cuda/cuda_primitives.cuh"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <new>
#include <numeric>
#include <vector>

#include "libaccel/core/counter_rng.h"
#include "libaccel/packet/serial_primitives.h"

namespace accel::cuda {
namespace {

const std::size_t kSizes[] = {0, 1, 2, 31, 32, 33, 255, 257, 4095, 4097, 100003, 3000017};

// Why there is nothing to test on this machine; empty where there is.
std::string no_device() {
  int count = 0;
  const cudaError_t code = cudaGetDeviceCount(&count);
  return code == cudaSuccess && count > 0 ? "" : std::string("no device: ") + cudaGetErrorString(code);
}

#define ACCEL_SKIP_WITHOUT_DEVICE() \
  if (const std::string reason = no_device(); !reason.empty()) GTEST_SKIP() << reason

template <class T>
DeviceArray<T> to_device(const std::vector<T>& values) {
  auto array = DeviceArray<T>::copy_of(values);
  EXPECT_TRUE(array.ok()) << array.message();
  return std::move(*array);
}

template <class T>
std::vector<T> to_host(const DeviceArray<T>& array) {
  std::vector<T> values(array.size());
  const Status copied = array.copy_to(values);
  EXPECT_TRUE(copied.ok()) << copied.message();
  return values;
}

template <class Body>
void expect_done(const Body& body) {
  const Status status = caught(body);
  EXPECT_TRUE(status.ok()) << status.message();
}

std::vector<std::uint32_t> random_values(std::size_t n, std::uint32_t below, std::uint64_t seed) {
  CounterRng rng(seed, n);
  std::vector<std::uint32_t> values(n);
  for (std::uint32_t& value : values) value = rng.next_below(below);
  return values;
}

// Set at random, on average one in `every`; flags are any number but zero.
std::vector<std::uint8_t> random_flags(std::size_t n, std::uint32_t every, std::uint64_t seed) {
  std::vector<std::uint8_t> flags;
  for (const std::uint32_t value : random_values(n, every, seed)) flags.push_back(value == 0 ? 3 : 0);
  return flags;
}

// Two sums at once, as packet/breadth_first.h counts.
struct TwoCounts {
  std::uint32_t a, b;

  ACCEL_HD TwoCounts& operator+=(const TwoCounts& other) { return a += other.a, b += other.b, *this; }
  bool operator==(const TwoCounts&) const = default;
};

// ---- What runs on the host

TEST(CudaPrimitivesOnTheHost, SegmentsAddUpHoweverTheyAreCut) {
  const std::size_t n = 60;
  for (const std::uint32_t every : {1u, 3u, 20u, 1000u}) {
    const auto values = random_values(n, 1000, 1);
    const auto heads = random_flags(n, every, 2);
    std::vector<std::uint32_t> expected(n);
    SerialPrimitives::inclusive_segmented_scan(values.data(), heads.data(), n, expected.data());
    const detail::SegmentAt<std::uint32_t> at{values.data(), heads.data()};
    const auto join = [&](std::uint32_t begin, std::uint32_t end) {
      auto joined = at(begin);
      for (std::uint32_t i = begin + 1; i < end; ++i) joined = detail::JoinSegments{}(joined, at(i));
      return joined;
    };
    // What comes before the cut, and what comes after it, in one piece or two.
    for (std::uint32_t end = 3; end <= n; ++end)
      for (std::uint32_t cut = 1; cut + 1 < end; ++cut) {
        const auto rest = detail::JoinSegments{}(join(cut, cut + 1), join(cut + 1, end));
        EXPECT_EQ(detail::SumOfSegment{}(detail::JoinSegments{}(join(0, cut), rest)), expected[end - 1]);
        EXPECT_EQ(detail::SumOfSegment{}(detail::JoinSegments{}(join(0, cut), join(cut, end))), expected[end - 1]);
      }
  }
}

TEST(CudaPrimitivesOnTheHost, WhatIsThrownBecomesAStatus) {
  EXPECT_TRUE(caught([] {}).ok());
  EXPECT_THAT(caught([] { throw_unless_done(cudaErrorInvalidValue, "a call"); }).message(),
              testing::AllOf(testing::HasSubstr("cudaErrorInvalidValue"), testing::HasSubstr("a call")));
  EXPECT_FALSE(caught([] { throw std::bad_alloc(); }).ok());
  EXPECT_TRUE(caught([] { ScratchArray<int> nothing(0); }).ok());
}

TEST(CudaPrimitivesOnTheHost, WithoutADeviceArraysSayWhy) {
  if (no_device().empty()) GTEST_SKIP() << "there is a device";
  EXPECT_THAT(caught([] { ScratchArray<int> array(3); }).message(), testing::HasSubstr("CUDA"));
}

// ---- What needs a device

TEST(CudaPrimitives, TooMuchMemoryIsAnErrorThatPasses) {
  ACCEL_SKIP_WITHOUT_DEVICE();
  EXPECT_FALSE(caught([] { ScratchArray<int> array(std::size_t{1} << 60); }).ok());
  EXPECT_EQ(cudaPeekAtLastError(), cudaSuccess);
  EXPECT_FALSE(DeviceArray<int>::allocate(std::size_t{1} << 60).ok());
  EXPECT_EQ(cudaPeekAtLastError(), cudaSuccess);
  expect_done([] { ScratchArray<int> array(3); });
}

void count_visits(std::uint32_t* visits, std::size_t n) {
  CudaPrimitives::for_each(n, [=] ACCEL_HD_LAMBDA(std::size_t i) { visits[i] += 1 + static_cast<std::uint32_t>(i); });
}

TEST(CudaPrimitives, ForEachVisitsEveryIndexOnce) {
  ACCEL_SKIP_WITHOUT_DEVICE();
  for (const std::size_t n : kSizes) {
    auto visits = to_device(std::vector<std::uint32_t>(n));
    expect_done([&] { count_visits(visits.data(), n); });
    std::vector<std::uint32_t> expected(n);
    std::iota(expected.begin(), expected.end(), 1u);
    EXPECT_EQ(to_host(visits), expected) << n;
  }
}

template <class T>
void expect_serial_exclusive_scan(const std::vector<T>& values) {
  const std::size_t n = values.size();
  std::vector<T> expected(n);
  const T expected_total = SerialPrimitives::exclusive_scan(values.data(), n, expected.data());
  auto in = to_device(values), out = to_device(values);
  T total{}, total_in_place{};
  expect_done([&] { total = CudaPrimitives::exclusive_scan(in.data(), n, out.data()); });
  EXPECT_EQ(total, expected_total) << n;
  EXPECT_EQ(to_host(out), expected) << n;
  expect_done([&] { total_in_place = CudaPrimitives::exclusive_scan(in.data(), n, in.data()); });
  EXPECT_EQ(total_in_place, expected_total) << n;
  EXPECT_EQ(to_host(in), expected) << n;
}

TEST(CudaPrimitives, ExclusiveScan) {
  ACCEL_SKIP_WITHOUT_DEVICE();
  for (const std::size_t n : kSizes) {
    const auto values = random_values(n, 1000, 3);
    expect_serial_exclusive_scan(values);
    std::vector<TwoCounts> counts;
    for (const std::uint32_t value : values) counts.push_back({value, value % 7});
    expect_serial_exclusive_scan(counts);
  }
}

TEST(CudaPrimitives, InclusiveSegmentedScan) {
  ACCEL_SKIP_WITHOUT_DEVICE();
  for (const std::size_t n : kSizes)
    for (const std::uint32_t every : {1u, 7u, 3000u, 1000000u}) {
      const auto values = random_values(n, 1000, 4);
      const auto flags = random_flags(n, every, 5);
      std::vector<std::uint32_t> expected(n);
      SerialPrimitives::inclusive_segmented_scan(values.data(), flags.data(), n, expected.data());
      auto in = to_device(values), out = to_device(values);
      const auto heads = to_device(flags);
      expect_done([&] { CudaPrimitives::inclusive_segmented_scan(in.data(), heads.data(), n, out.data()); });
      EXPECT_EQ(to_host(out), expected) << n << ", a head in " << every;
      expect_done([&] { CudaPrimitives::inclusive_segmented_scan(in.data(), heads.data(), n, in.data()); });
      EXPECT_EQ(to_host(in), expected) << n << ", a head in " << every;
    }
}

TEST(CudaPrimitives, Compact) {
  ACCEL_SKIP_WITHOUT_DEVICE();
  for (const std::size_t n : kSizes)
    for (const std::uint32_t every : {1u, 5u, 4000u}) {
      const auto flags = random_flags(n, every, 6);
      std::vector<std::uint32_t> expected(n);
      expected.resize(SerialPrimitives::compact(flags.data(), n, expected.data()));
      const auto on_device = to_device(flags);
      auto out = to_device(std::vector<std::uint32_t>(n));
      std::size_t count = 0;
      expect_done([&] { count = CudaPrimitives::compact(on_device.data(), n, out.data()); });
      std::vector<std::uint32_t> found = to_host(out);
      ASSERT_LE(count, n);
      found.resize(count);
      EXPECT_EQ(found, expected) << n << ", a flag in " << every;
    }
}

template <class Key>
void expect_serial_sort(std::vector<Key> keys) {
  const std::size_t n = keys.size();
  std::vector<std::uint32_t> values(n);
  std::iota(values.begin(), values.end(), 0u);
  auto device_keys = to_device(keys);
  auto device_values = to_device(values);
  expect_done([&] { CudaPrimitives::sort_pairs(device_keys.data(), device_values.data(), n); });
  SerialPrimitives::sort_pairs(keys.data(), values.data(), n);
  EXPECT_EQ(to_host(device_keys), keys) << n;
  EXPECT_EQ(to_host(device_values), values) << n;
}

// The masks leave out bits, at both ends and in between, so that the number of passes is even or odd; equal keys are many.
TEST(CudaPrimitives, SortPairs) {
  ACCEL_SKIP_WITHOUT_DEVICE();
  for (const std::size_t n : kSizes) {
    CounterRng rng(7, n);
    std::vector<std::uint64_t> random(n);
    for (std::uint64_t& key : random) key = rng.next_u64();
    for (const std::uint64_t mask : {~0ull, 0ull, 1ull, 0xff00ff00ull, 0xffff000000ull, 0x3ull << 62}) {
      std::vector<std::uint64_t> wide;
      std::vector<std::uint32_t> narrow;
      for (const std::uint64_t key : random)
        wide.push_back(key & mask), narrow.push_back(static_cast<std::uint32_t>(key & mask));
      expect_serial_sort(wide);
      expect_serial_sort(narrow);
    }
  }
}

}  // namespace
}  // namespace accel::cuda
