#include <string>

#include "libaccel/geometry/mesh_facts.h"
#include "libaccel/rays/ray_sets.h"

namespace accel {

Result<RaySet> secondary_rays(RayKind kind, const PrimaryHits& from, const LightDescription& light, std::uint64_t seed) {
  switch (kind) {
    case RayKind::shadow:
      return shadow_rays(from, light);
    case RayKind::soft_shadow:
      return soft_shadow_rays(from, light, seed);
    case RayKind::diffuse:
      return diffuse_rays(from, seed);
    case RayKind::ao:
      return ao_rays(from, default_ao_distance(mesh_facts(from.triangles).bounds), seed);
    default:
      return Error{"'" + std::string(info(kind).name) + "' rays do not start from hits"};
  }
}

}  // namespace accel
