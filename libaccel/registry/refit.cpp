#include "libaccel/registry/refit.h"

#include <new>
#include <string>
#include <utility>

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

}  // namespace accel
