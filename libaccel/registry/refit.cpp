#include "libaccel/registry/refit.h"

#include <new>
#include <string>
#include <utility>

#include "libaccel/build/top_level.h"
#include "libaccel/build/wide_instances.h"
#include "libaccel/core/out_of_memory.h"

namespace accel {

Result<RefittedAccel> refit(const AnyAccel& accel, const TriangleMesh& mesh, const BuildOptions& options) try {
  const auto* const bvh = accel.structure().get_if<Bvh8>();
  if (bvh == nullptr)
    return Error{"refitting: a '" + accel.method().structure + "' cannot be refitted, a '" + std::string(Bvh8::kName) +
                 "' can; rebuild"};
  if (const Status valid = validate(mesh); !valid) return valid.error();
  const BuildReport& report = accel.report();
  const std::uint64_t built = report.triangles + report.skipped.zero_area + report.skipped.out_of_range;
  if (built != 0 && built != mesh.size())  // structures from files have no report
    return Error{"refitting: the structure was built over " + std::to_string(built) + " triangles, but the mesh has " +
                 std::to_string(mesh.size()) + "; rebuild"};
  Result<RefittedBvh8> refitted = refit_wide(*bvh, mesh, options);
  if (!refitted) return refitted.error();
  auto bound = AnyAccel::bind(std::move(refitted->structure), accel.method().name, report);
  if (!bound) return bound.error();
  return RefittedAccel{*std::move(bound), refitted->costs, refitted->seconds};
} catch (const std::bad_alloc&) {
  return out_of_memory("refitting a structure");
}

Result<AnyAccel> move_instances(const AnyAccel& accel, const InstancedMeshes& scene, const BuildOptions& options) try {
  const auto* const bvh = accel.structure().get_if<TwoLevelBvh8>();
  if (bvh == nullptr)
    return Error{"moving instances: a '" + accel.method().structure + "' cannot move them, a '" +
                 std::string(TwoLevelBvh8::kName) + "' can (" + std::string(WideInstances::kName) + "); rebuild"};
  Result<Built<TwoLevelBvh8>> moved = accel::move_instances(*bvh, scene, options);
  if (!moved) return moved.error();
  BuildReport report = accel.report();
  report.seconds = moved->report.seconds, report.phases = std::move(moved->report.phases);
  report.peak_bytes = moved->report.peak_bytes;
  const BuildNote placed = instances_note(scene, report.triangles);
  for (BuildNote& note : report.notes)
    if (note.what == placed.what) note = placed;
  return AnyAccel::bind(std::move(moved->structure), accel.method().name, std::move(report));
} catch (const std::bad_alloc&) {
  return out_of_memory("moving instances");
}

}  // namespace accel
