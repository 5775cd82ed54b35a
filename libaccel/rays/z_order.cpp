#include "libaccel/rays/z_order.h"

#include <algorithm>
#include <bit>

namespace accel {
namespace {

// Appends the pixels of the square of 2^level pixels a side at (x, y) that lie in the picture.
struct ZCurve {
  std::uint64_t width, height;
  std::uint32_t* next;

  void visit(std::uint64_t x, std::uint64_t y, int level) {
    if (x >= width || y >= height) return;
    if (level == 0) {
      *next++ = static_cast<std::uint32_t>(y * width + x);
      return;
    }
    const std::uint64_t half = 1ull << (level - 1);
    visit(x, y, level - 1), visit(x + half, y, level - 1);
    visit(x, y + half, level - 1), visit(x + half, y + half, level - 1);
  }
};

}  // namespace

Buffer<std::uint32_t> z_order_pixels(std::uint32_t width, std::uint32_t height) {
  Buffer<std::uint32_t> pixels(std::size_t{width} * height);
  if (pixels.empty()) return pixels;
  ZCurve{width, height, pixels.data()}.visit(0, 0, std::bit_width(std::max(width, height) - 1));
  return pixels;
}

}  // namespace accel
