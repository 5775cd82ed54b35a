// Clusters of triangles along a diagonal line, each kRatio times smaller and nearer to the origin than the one before.
//
// Why a SAH builder goes deep here. A level's box [0, 1]^3 holds its outermost cluster of c triangles in [0.6, 1]^3 and R
// triangles of all inner levels in [0, 1/3]^3. With areas as shares of the level's box, cutting off the cluster costs 0.16 c +
// 0.11 R. Cutting off the two outermost clusters at once costs about 0.64 (c + c') + 0.012 R', because their common box spans
// [0.2, 1]^3. The first is the cheaper as long as c is at least a tenth of R, so every cluster costs the tree a level, and a
// chain of kLevels of them a depth of nearly kLevels. Cluster sizes therefore grow outwards by a constant factor, from one
// triangle in the middle. Binned builders see the same: all inner clusters share the first bins.
//
// Coordinates reach from 2^-60 to 2^58: within the range where the triangle tests neither underflow nor overflow.
#include <algorithm>
#include <cmath>
#include <vector>

#include "libaccel/core/counter_rng.h"
#include "scenes/generators.h"
#include "scenes/mesh_builder.h"

namespace accel {
namespace {

constexpr double kRatio = 3;
constexpr double kLargest = 0x1p58;
constexpr int kLevels = 75;  // kRatio^-kLevels is about 2^-118.9
constexpr double kLeastGrowth = 1.12;

// Sizes of the clusters from the innermost one, when each is `growth` - 1 times all that lie within it, but at least one
// triangle.
std::vector<std::uint64_t> cluster_sizes(double growth) {
  std::vector<std::uint64_t> sizes;
  double total = 0;
  for (int level = 0; level < kLevels; ++level) {
    const double here = std::max(1.0, std::floor(total * (growth - 1)));
    sizes.push_back(static_cast<std::uint64_t>(here));
    total += here;
  }
  return sizes;
}

std::uint64_t sum(const std::vector<std::uint64_t>& sizes) {
  std::uint64_t total = 0;
  for (const std::uint64_t s : sizes) total += s;
  return total;
}

// The growth that comes closest to `size` triangles without falling below what keeps the chain.
double growth_for(std::uint64_t size) {
  double lo = kLeastGrowth, hi = 2;
  for (int i = 0; i < 60; ++i) {
    const double middle = (lo + hi) / 2;
    (sum(cluster_sizes(middle)) < size ? lo : hi) = middle;
  }
  return lo;
}

// Corner `corner` of a triangle in the cluster that fills [0.6, 1]^3 times `scale`.
Vec3d corner_of(CounterRng rng, std::uint32_t corner, double scale) {
  Vec3d p{0, 0, 0};
  const double x = 0.6 + 0.35 * rng.next_double(), y = 0.6 + 0.35 * rng.next_double(), z = 0.6 + 0.35 * rng.next_double();
  for (std::uint32_t i = 0; i <= corner; ++i) {
    const double dx = 0.05 * rng.next_double(), dy = 0.05 * rng.next_double(), dz = 0.05 * rng.next_double();
    p = Vec3d{x + dx, y + dy, z + dz} * scale;
  }
  return p;
}

}  // namespace

SceneData make_deep(std::uint64_t size, std::uint64_t seed) {
  std::vector<std::uint64_t> sizes = cluster_sizes(growth_for(size));
  sizes.back() += size - std::min(size, sum(sizes));
  MeshBuilder builder;
  for (int level = 0; level < kLevels; ++level) {
    const double scale = kLargest * std::pow(kRatio, level - (kLevels - 1));
    const auto stream = static_cast<std::uint64_t>(level);
    const std::uint64_t count = sizes[static_cast<std::size_t>(level)];
    builder.add(
        3 * count, count, [=](std::uint32_t i) { return corner_of(CounterRng(seed, i / 3, stream), i % 3, scale); },
        [](std::uint32_t i) {
          return IndexTriple{3 * i, 3 * i + 1, 3 * i + 2};
        });
  }
  const auto far = static_cast<float>(kLargest);
  return {builder.build(),
          {{{0.5f * far, 1.2f * far, 3.0f * far}, {0.5f * far, 0.5f * far, 0.5f * far}, {0, 1, 0}, 40, "default"}},
          {}};
}

}  // namespace accel
