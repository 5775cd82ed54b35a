// Thin tubes that wind about a sphere: large overlapping boxes, hardly any empty space, little hope for object splits.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "libaccel/core/counter_rng.h"
#include "scenes/generators.h"
#include "scenes/mesh_builder.h"

namespace accel {
namespace {

constexpr std::uint32_t kSides = 4;
constexpr double kThickness = 0.004, kStrandLength = 2.4;  // for a ball of radius 1
constexpr int kWaves = 4;

// The axis of a strand: a short walk over the sphere, as a sum of waves, that rises and sinks.
struct Strand {
  Vec3d start, heading;
  Vec3d wave[kWaves];
  double phase[kWaves];
  double radius, lift;

  Strand(std::uint64_t seed, std::uint64_t index) {
    CounterRng rng(seed, index);
    const auto direction = [&] {
      const double z = 2 * rng.next_double() - 1, angle = 2 * std::numbers::pi * rng.next_double();
      const double r = std::sqrt(1 - z * z);
      return Vec3d{r * std::cos(angle), r * std::sin(angle), z};
    };
    start = direction(), heading = direction();
    for (int i = 0; i < kWaves; ++i)
      wave[i] = direction() * (0.25 / (1 + i)), phase[i] = 2 * std::numbers::pi * rng.next_double();
    radius = 0.75 + 0.15 * rng.next_double(), lift = 0.12 * rng.next_double();
  }

  Vec3d at(double t) const {
    Vec3d p = start + heading * (kStrandLength * (t - 0.5));
    for (int i = 0; i < kWaves; ++i) p = p + wave[i] * std::sin(phase[i] + 2 * std::numbers::pi * (i + 1) * t);
    return normalized(p) * (radius + lift * std::sin(phase[0] + 9 * t));
  }
};

}  // namespace

SceneData make_hairball(std::uint64_t size, std::uint64_t seed) {
  // Fewer, coarser strands in small scenes; from some ten thousand triangles on, only their number grows.
  const auto segments = static_cast<std::uint32_t>(std::clamp(std::sqrt(static_cast<double>(size)) / 4, 1.0, 32.0));
  const std::uint32_t per_strand = 2 * kSides * segments;
  const std::uint64_t strands = std::max<std::uint64_t>(1, (size + per_strand / 2) / per_strand);

  MeshBuilder builder;
  for (std::uint64_t s = 0; s < strands; ++s) {
    builder.add_grid(kSides, segments, GridShape::tube, [=](double u, double v) {
      const Strand strand(seed, s);
      const Vec3d center = strand.at(v), outwards = normalized(center);
      const Vec3d along = normalized(strand.at(v + 1e-3) - strand.at(v - 1e-3));
      const Vec3d across = normalized(cross(outwards, along)), up = cross(along, across);
      const double angle = 2 * std::numbers::pi * u, thickness = kThickness * (1 - 0.8 * v);
      return center + (across * std::cos(angle) + up * std::sin(angle)) * thickness;
    });
  }
  return {builder.build(), {{{0.9f, 0.7f, 2.4f}, {0, 0, 0}, {0, 1, 0}, 42, "default"}}, {}};
}

}  // namespace accel
