// The rows of a picture among rays that come row by row, as those of cameras do, and what is sent from the surfaces that they
// meet: where rows are known, tiles of them are packets (packet/block_order.h) for less than sorting costs.
//
// Nothing but the rays tells of rows: the ray below another one is nearer to it than one some pixels further on. Rows that lack
// a few rays, because some met nothing, are rows all the same; what is found matters for speed alone.
#pragma once

#include <cstddef>
#include <span>

#include "libaccel/core/ray.h"

namespace accel {

struct PixelRows {
  std::size_t length = 0;  // of a row, in rays; 0 if there are no rows
  std::size_t first = 0;   // where the first whole row begins; what comes before is the end of another one
};

// `scale`: one over a length that matters as much as turning by a radian, such as the scene's diagonal. Rows shorter than
// 128 rays, or longer than an eighth of all rays, are not found.
PixelRows find_rows(std::span<const Ray> rays, float scale);

}  // namespace accel
