// Pixels along a Z-curve (core/morton.h).
#pragma once

#include <cstdint>

#include "libaccel/core/buffer.h"

namespace accel {

// The pixels y * width + x of a picture of any size in the order of their Morton codes. Linear in the number of pixels.
Buffer<std::uint32_t> z_order_pixels(std::uint32_t width, std::uint32_t height);

}  // namespace accel
