#include "libaccel/rays/ray_kind.h"

#include <array>

#include "libaccel/core/suggest.h"

namespace accel {
namespace {

constexpr std::array<RayKindInfo, kRayKinds> kKinds{{
    {RayKind::primary, "primary", "from the camera through every pixel", Query::closest, true, false},
    {RayKind::shadow, "shadow", "from every primary hit to the centre of the light", Query::any, true, true},
    {RayKind::soft_shadow, "soft-shadow", "from every primary hit to 16 points of the light", Query::any, true, true},
    {RayKind::diffuse, "diffuse", "one cosine-weighted bounce from every primary hit", Query::closest, true, true},
    {RayKind::ao, "ao", "short cosine-weighted rays from every primary hit", Query::any, true, true},
    {RayKind::random, "random", "uniform origins in and around the scene, uniform directions", Query::closest, false, false},
    {RayKind::edge, "edge", "aimed at shared vertices and edges of the mesh", Query::closest, false, false},
}};

}  // namespace

std::span<const RayKindInfo> ray_kinds() { return kKinds; }

const RayKindInfo& info(RayKind kind) { return kKinds[static_cast<std::size_t>(kind)]; }

Result<RayKind> parse_ray_kind(std::string_view name) {
  std::array<std::string_view, kRayKinds> names;
  for (int i = 0; i < kRayKinds; ++i) {
    names[i] = kKinds[i].name;
    if (names[i] == name) return kKinds[i].kind;
  }
  return unknown_name("ray kind", name, names);
}

}  // namespace accel
