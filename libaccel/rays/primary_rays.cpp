#include <new>
#include <string>

#include "libaccel/core/counter_rng.h"
#include "libaccel/core/out_of_memory.h"
#include "libaccel/rays/fill.h"
#include "libaccel/rays/ray_sets.h"
#include "libaccel/rays/sampling.h"
#include "libaccel/rays/z_order.h"

namespace accel {

Result<RaySet> primary_rays(const Camera& camera, std::uint32_t spp, std::uint64_t seed, PixelOrder order) try {
  const std::uint64_t width = camera.width(), pixels = width * camera.height();
  if (spp == 0) return Error{"primary rays: 0 samples per pixel; ask for at least 1"};
  if (pixels > kMaxRays / spp)
    return Error{"primary rays: " + std::to_string(pixels) + " pixels of " + std::to_string(spp) +
                 " samples are more than 2^32 rays; make the picture smaller"};

  const Buffer<std::uint32_t> z_curve =
      order == PixelOrder::z_curve ? z_order_pixels(camera.width(), camera.height()) : Buffer<std::uint32_t>();
  RaySet set{Buffer<Ray>(pixels * spp), Buffer<std::uint32_t>(pixels * spp)};
  fill(set.pixel.span(),
       [&](std::size_t i) { return order == PixelOrder::z_curve ? z_curve[i / spp] : static_cast<std::uint32_t>(i / spp); });
  fill(set.rays.span(), [&](std::size_t i) {
    const std::uint32_t pixel = set.pixel[i];
    UnitPoint point{0.5, 0.5};
    if (spp > 1) {
      const auto sample = static_cast<std::uint32_t>(i % spp);
      CounterRng rng(seed, std::uint64_t{pixel} * spp + sample);
      point = point_in_cell(sample, spp, rng);
    }
    return camera.ray(static_cast<double>(pixel % width) + point.x, static_cast<double>(pixel / width) + point.y);
  });
  return set;
} catch (const std::bad_alloc&) {
  return out_of_memory("making primary rays; make the picture smaller");
}

}  // namespace accel
