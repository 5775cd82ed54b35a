// Structure files: whatever the bytes, opening, validating and tracing end without a crash.
//
// Each input is read twice: as it is, which hardly any change of a file survives, and with the checksums ignored, so that the
// changes come to the validators of structures. What they let pass is traced by every method of its kind.
#include <cmath>
#include <limits>
#include <vector>

#include "libaccel/io/structure_sections.h"
#include "libaccel/registry/any_accel.h"
#include "libaccel/registry/structures.h"
#include "validation/fuzz/fuzz_input.h"

namespace {

using namespace accel;

// Rays from all sides through the middle of the box, along its diagonals and sides, and one that is no ray.
std::vector<Ray> rays_through(const Aabb& box) {
  const Vec3 lo = box.empty() ? Vec3{0, 0, 0} : box.lo, hi = box.empty() ? Vec3{1, 1, 1} : box.hi;
  std::vector<Ray> rays;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 org;
    for (int k = 0; k < 3; ++k) org[k] = (corner >> k & 1) != 0 ? hi[k] : lo[k];
    const Vec3 opposite = {lo.x + (hi.x - org.x), lo.y + (hi.y - org.y), lo.z + (hi.z - org.z)};
    Vec3 along{0, 0, 0};
    along[corner % 3] = corner % 2 == 0 ? 1.0f : -1.0f;
    rays.push_back({.org = org, .dir = opposite - org});
    rays.push_back({.org = org, .dir = along});
    rays.push_back({.org = 0.5f * lo + 0.5f * hi, .dir = org - (0.5f * lo + 0.5f * hi)});
  }
  rays.push_back({.org = lo, .dir = {std::numeric_limits<float>::quiet_NaN(), 0, 1}});
  return rays;
}

void trace(const AnyStructure& structure, const std::vector<Ray>& rays) {
  for (const MethodInfo& method : methods()) {
    if (method.structure != structure.kind()) continue;
    const Result<AnyAccel> accel = AnyAccel::bind(structure, method.name);
    if (!accel) continue;  // too deep, say
    std::vector<Hit> hits(rays.size());
    std::vector<std::uint8_t> occluded(rays.size());
    fuzz::require(accel->closest(rays, hits, {.threads = 1}).ok(), "tracing fails with " + method.name);
    fuzz::require(accel->occluded(rays, occluded, {.threads = 1}).ok(), "occlusion fails with " + method.name);
  }
}

void read_all(const Result<AccelFile>& file) {
  if (!file) return fuzz::require(!file.message().empty(), "an error without a message");
  (void)read<AccelMetadata>(*file);
  (void)(has_instances(*file) ? read<InstancedMeshes>(*file).ok() : read<TriangleMesh>(*file).ok());
  const Result<MeshFacts> facts = read<MeshFacts>(*file);
  const std::vector<Ray> rays = rays_through(facts ? facts->bounds : Aabb{});
  Structures::for_each([&](auto tag) {
    auto structure = read<typename decltype(tag)::type>(*file);
    if (structure) trace(AnyStructure(*std::move(structure)), rays);
  });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::InputFile file(".accel");
  const std::filesystem::path& path = file.holding({data, size});
  read_all(AccelFile::open(path));
  read_all(AccelFile::open(path, VerifyChecksums::no));
  return 0;
}
