// Seeded procedural scenes: `builtin:NAME[:size]` on the command lines.
//
// Every scene scales from a handful to tens of millions of triangles. Its bytes depend on the spec and the seed only, not on
// the number of threads: each element draws its random numbers from a counter (libaccel/core/counter_rng.h). Coordinates are
// finite and in range. Time and memory are linear in the size.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "libaccel/core/result.h"
#include "libaccel/geometry/scene_data.h"

namespace accel {

struct BuiltinScene {
  std::string_view name;
  std::string_view description;  // one line, without a full stop
  std::uint64_t default_size;    // triangles, approximately
};

// All scenes; stadium, the default of the tools, comes first.
std::span<const BuiltinScene> builtin_scenes();

// The largest size that a spec may ask for.
inline constexpr std::uint64_t kMaxBuiltinSize = 200'000'000;

// The scene that `spec` names: "stadium", "stadium:100000", "stadium:100k", "stadium:2M" or "stadium:1.5M", with or without
// "builtin:" before it. The size is the approximate number of triangles wanted; scenes have a least size of their own and a
// granularity of their parts. Errors: an unknown name (with a suggestion), a size that is no positive number or above
// kMaxBuiltinSize.
Result<SceneData> make_builtin(std::string_view spec, std::uint64_t seed = 1);
// Whether there is such a scene, without making it; the errors are the same.
Status check_builtin(std::string_view spec);

}  // namespace accel
