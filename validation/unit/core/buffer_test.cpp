#include "libaccel/core/buffer.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <new>
#include <numeric>
#include <utility>
#include <vector>

namespace accel {
namespace {

TEST(Buffer, IsEmptyByDefault) {
  const Buffer<int> buffer;
  EXPECT_TRUE(buffer.empty());
  EXPECT_EQ(buffer.size(), 0u);
  EXPECT_EQ(buffer.begin(), buffer.end());
  EXPECT_TRUE(Buffer<int>(0).empty());
}

TEST(Buffer, IsAlignedToCacheLines) {
  for (const std::size_t size : {1u, 3u, 100u, 4097u}) {
    const Buffer<char> buffer(size);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(buffer.data()) % kBufferAlignment, 0u);
    EXPECT_EQ(buffer.size_bytes(), size);
  }
}

TEST(Buffer, LargeOnesBeginAtAHugePage) {
  constexpr std::size_t kHugePage = std::size_t{2} << 20;
  Buffer<char> buffer(5 * kHugePage / 2 + 1);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(buffer.data()) % kHugePage, 0u);
  buffer[0] = 1, buffer[buffer.size() - 1] = 2;
  const Buffer<char> copy = Buffer<char>::copy_of(buffer.span());
  EXPECT_EQ(copy[0] + copy[copy.size() - 1], 3);
}

TEST(Buffer, CopiesShareTheStorage) {
  Buffer<int> first(10);
  std::iota(first.begin(), first.end(), 0);
  Buffer<int> second = first;
  second[3] = 42;
  EXPECT_EQ(first[3], 42);
  first = Buffer<int>();
  EXPECT_EQ(second[3], 42);
  EXPECT_EQ(second[9], 9);
}

TEST(Buffer, MovedFromOnesAreEmpty) {
  Buffer<int> first(10);
  first[9] = 7;
  Buffer<int> second = std::move(first);
  EXPECT_TRUE(first.empty());
  EXPECT_EQ(first.data(), nullptr);
  EXPECT_EQ(second[9], 7);
  first = std::move(second);
  EXPECT_TRUE(second.empty());
  EXPECT_EQ(first[9], 7);
}

// As many elements as would wrap around when they are counted in bytes, or in pages.
TEST(Buffer, MoreThanMemoryIsBadAlloc) {
  EXPECT_THROW(Buffer<std::uint64_t>(std::size_t{1} << 61), std::bad_alloc);
  EXPECT_THROW(Buffer<std::uint64_t>((std::size_t{1} << 61) + 1), std::bad_alloc);
  EXPECT_THROW(Buffer<char>(SIZE_MAX - 5), std::bad_alloc);
}

TEST(Buffer, CopyOfDoesNotShare) {
  std::vector<int> values = {1, 2, 3};
  const Buffer<int> buffer = Buffer<int>::copy_of(values);
  values[0] = 9;
  EXPECT_EQ(buffer[0], 1);
  EXPECT_EQ(buffer.span().size(), 3u);
}

TEST(Buffer, BorrowsAndKeepsAlive) {
  auto owner = std::make_shared<std::vector<int>>(std::vector<int>{1, 2, 3});
  const std::weak_ptr<std::vector<int>> watch = owner;
  Buffer<int> buffer(owner->data(), owner->size(), owner);
  owner.reset();
  EXPECT_FALSE(watch.expired());
  EXPECT_EQ(buffer[2], 3);
  buffer = {};
  EXPECT_TRUE(watch.expired());
}

TEST(Buffer, TruncateOnlyShrinks) {
  Buffer<int> buffer(5);
  buffer.truncate(3);
  EXPECT_EQ(buffer.size(), 3u);
  buffer.truncate(4);
  EXPECT_EQ(buffer.size(), 3u);
}

}  // namespace
}  // namespace accel
