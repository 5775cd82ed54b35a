#include "libaccel/packet/block_order.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "libaccel/packet/frustums_simd.h"
#include "libaccel/packet/serial_primitives.h"

namespace accel {

void BlockOrder::begin(std::span<const Ray> rays) {
  rays_ = rays;
  faces_by_ray_.resize(rays.size());
  find_faces_simd(rays.data(), rays.size(), faces_by_ray_.data());
}

void BlockOrder::sort(std::uint32_t run) {
  ids_.resize(rays_.size());
  if (run == 0)
    std::iota(ids_.begin(), ids_.end(), 0u);
  else
    sort_runs(run);
  sort_by_face();
}

void BlockOrder::sort_runs(std::uint32_t run) {
  const std::size_t n = rays_.size(), count = (n + run - 1) / run;
  values_.resize(count), runs_.resize(count);
  for (std::size_t r = 0; r < count; ++r) values_[r] = hash_(rays_[std::min(r * run + run / 2, n - 1)]);
  std::iota(runs_.begin(), runs_.end(), 0u);
  SerialPrimitives::sort_pairs(values_.data(), runs_.data(), count);
  auto id = ids_.begin();
  for (const std::size_t r : runs_)
    for (std::size_t i = r * run, end = std::min(i + run, n); i < end; ++i) *id++ = static_cast<std::uint32_t>(i);
}

// Keeps the order among rays of one face.
void BlockOrder::sort_by_face() {
  std::array<std::uint32_t, kNoFace + 1> next{};
  for (const std::uint8_t face : faces_by_ray_) ++next[face];
  std::exclusive_scan(next.begin(), next.end(), next.begin(), 0u);
  ids_before_ = ids_, faces_.resize(ids_.size());
  for (const std::uint32_t id : ids_before_) {
    const std::uint8_t face = faces_by_ray_[id];
    const std::uint32_t at = next[face]++;
    ids_[at] = id, faces_[at] = face;
  }
}

void BlockOrder::keep(std::span<const std::pair<std::uint32_t, std::uint32_t>> places) {
  std::size_t kept = 0;
  for (const auto& [first, end] : places) {
    std::copy(ids_.begin() + first, ids_.begin() + end, ids_.begin() + static_cast<std::ptrdiff_t>(kept));
    std::copy(faces_.begin() + first, faces_.begin() + end, faces_.begin() + static_cast<std::ptrdiff_t>(kept));
    kept += end - first;
  }
  ids_.resize(kept), faces_.resize(kept);
}

}  // namespace accel
