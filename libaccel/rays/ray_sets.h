// Seeded sets of rays, of the kinds that renderers trace.
//
// A set depends on its arguments and the seed only, not on the number of threads: every ray draws its random numbers from its
// own counter (libaccel/core/counter_rng.h), and sets are filled in parallel. Directions have unit length (to a few roundings),
// so t is in scene units, except those of edge rays, which see.
//
// Rays come in an order that keeps neighbours together, on which no ray depends. Primary rays: by pixel, in rows or along a
// Z-curve, the samples of a pixel side by side. Secondary rays: in the order of the primary rays that they start from; primary
// rays without a hit have no secondary rays, so a secondary set may be smaller. `pixel` says for every ray which pixel of the
// picture it belongs to.
//
// How secondary rays leave a surface without an epsilon: see offset_origin.h.
//
// Errors: empty pictures, sets of more than kMaxRays rays or than memory holds, no rays from a hit, hits that do not match the
// primary rays or name no triangle of the scene.
#pragma once

#include <cstdint>
#include <span>

#include "libaccel/core/buffer.h"
#include "libaccel/core/hit.h"
#include "libaccel/core/light_description.h"
#include "libaccel/core/ray.h"
#include "libaccel/core/result.h"
#include "libaccel/geometry/triangle_source.h"
#include "libaccel/rays/camera.h"
#include "libaccel/rays/ray_kind.h"

namespace accel {

inline constexpr std::uint64_t kMaxRays = 1ull << 32;

struct RaySet {
  Buffer<Ray> rays;
  Buffer<std::uint32_t> pixel;  // y * width + x for every ray; empty for kinds that belong to no picture (random, edge)

  std::size_t size() const { return rays.size(); }
};

enum class PixelOrder : std::uint8_t { rows, z_curve };

// "rows", "z-curve"
constexpr const char* order_name(PixelOrder order) { return order == PixelOrder::rows ? "rows" : "z-curve"; }

// `spp` rays through every pixel: its centre when spp is 1, otherwise one random point in each of spp cells of equal area.
Result<RaySet> primary_rays(const Camera& camera, std::uint32_t spp = 1, std::uint64_t seed = 1,
                            PixelOrder order = PixelOrder::rows);

// What secondary rays start from: primary rays and their closest hits, one for each.
struct PrimaryHits {
  TriangleSource triangles;
  const RaySet& primary;
  std::span<const Hit> hits;
};

// One ray from every hit to the centre of the light. Its interval ends at the light (t_max is the distance, rounded down) and
// is closed. Any-hit queries: a hit means shadow.
Result<RaySet> shadow_rays(const PrimaryHits& from, const LightDescription& light);

// `samples` rays from every hit to random points in equal cells of the light, side by side.
inline constexpr std::uint32_t kSoftShadowSamples = 16;
Result<RaySet> soft_shadow_rays(const PrimaryHits& from, const LightDescription& light, std::uint64_t seed = 1,
                                std::uint32_t samples = kSoftShadowSamples);

// One bounce from every hit: cosine-weighted about the geometric normal that faces the viewer, unbounded.
Result<RaySet> diffuse_rays(const PrimaryHits& from, std::uint64_t seed = 1);

// One ambient-occlusion ray from every hit: as diffuse, but its interval ends at max_distance. Any-hit queries.
Result<RaySet> ao_rays(const PrimaryHits& from, float max_distance, std::uint64_t seed = 1);

// The distance that ao_rays looks by default: a tenth of the box's diagonal.
float default_ao_distance(const Aabb& bounds);

// The secondary kinds by name, with default_ao_distance of the mesh: shadow, soft_shadow, diffuse, ao.
Result<RaySet> secondary_rays(RayKind kind, const PrimaryHits& from, const LightDescription& light, std::uint64_t seed = 1);

// Origins uniform in the box enlarged by a tenth on every side, directions uniform on the sphere.
Result<RaySet> random_rays(const Aabb& bounds, std::uint64_t count, std::uint64_t seed = 1);

// Rays aimed at vertices (even rays) and at points of edges (odd rays) of random triangles: where leaks are. Origins lie in the
// box (half of them) and around it. The direction is target - origin, so t is 1 at the target; the origin is moved by the
// rounding error of that difference, which makes org + dir the target exactly wherever floats permit it. Targets on edges are
// halves, quarters or eighths between the two vertices, rounded. An empty mesh gives an empty set.
Result<RaySet> edge_rays(const TriangleSource& triangles, std::uint64_t count, std::uint64_t seed = 1);

}  // namespace accel
