#include "libaccel/core/buffer.h"

#include <sys/mman.h>

#include <new>

namespace accel::detail {

namespace {

constexpr std::size_t kHugePage = std::size_t{2} << 20;

std::align_val_t alignment_of(std::size_t bytes) {
  return std::align_val_t{bytes >= 2 * kHugePage ? kHugePage : kBufferAlignment};
}

}  // namespace

void* allocate_buffer(std::size_t bytes) {
  const std::align_val_t alignment = alignment_of(bytes);
  void* const memory = ::operator new(bytes, alignment);
  // A wish: where the system has no such pages, nothing changes.
  if (static_cast<std::size_t>(alignment) == kHugePage) madvise(memory, bytes / kHugePage * kHugePage, MADV_HUGEPAGE);
  return memory;
}

void free_buffer(void* memory, std::size_t bytes) { ::operator delete(memory, alignment_of(bytes)); }

}  // namespace accel::detail
