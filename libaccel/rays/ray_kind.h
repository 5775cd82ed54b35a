// The kinds of rays that the tools trace, by their names on the command line.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "libaccel/core/hit.h"
#include "libaccel/core/result.h"

namespace accel {

enum class RayKind : std::uint8_t { primary, shadow, soft_shadow, diffuse, ao, random, edge };
inline constexpr int kRayKinds = 7;

struct RayKindInfo {
  RayKind kind;
  std::string_view name;         // on the command line and in reports
  std::string_view description;  // one line, without a full stop
  Query query;                   // what a renderer asks of such rays: the closest hit, or any
  bool is_image;                 // made from the pixels of a picture; the others are made from a count
  bool needs_hits;               // made from the hits of primary rays
};

// All kinds, in the order of the enumeration.
std::span<const RayKindInfo> ray_kinds();
const RayKindInfo& info(RayKind kind);

// The kind called `name`, or an Error with a suggestion.
Result<RayKind> parse_ray_kind(std::string_view name);

}  // namespace accel
