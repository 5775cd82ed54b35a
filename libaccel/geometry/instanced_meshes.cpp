#include "libaccel/geometry/instanced_meshes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <new>
#include <optional>
#include <string>

#include "libaccel/core/float_bounds.h"
#include "libaccel/core/hit.h"
#include "libaccel/core/out_of_memory.h"
#include "libaccel/geometry/mesh_facts.h"

namespace accel {
namespace {

// The box of the triangles that are in range.
Aabb bounds_of(const TriangleMesh& mesh) {
  Aabb box;
  for (std::size_t i = 0; i < mesh.size(); ++i)
    if (const Triangle t = mesh.triangle(i); is_in_range(t)) box.extend(t.bounds());
  return box;
}

// Whether the corners of the box stay in range, and with them all that is in the box.
bool stays_in_range(const Affine& transform, const Aabb& box) {
  if (box.empty()) return true;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 p{(corner & 1 ? box.hi : box.lo).x, (corner & 2 ? box.hi : box.lo).y, (corner & 4 ? box.hi : box.lo).z};
    if (!in_range(placed(transform, p))) return false;
  }
  return true;
}

Status check_instance(const Instance& instance, const std::vector<Aabb>& bounds) {
  if (instance.mesh >= bounds.size())
    return Error{"is of mesh " + std::to_string(instance.mesh + 1ull) + ", but there are " + std::to_string(bounds.size())};
  if (const auto inverted = inverse(instance.transform); !inverted) return Error{"its transform " + inverted.message()};
  if (!stays_in_range(instance.transform, bounds[instance.mesh]))
    return Error{"its transform takes triangles out of the range of coordinates"};
  return Done{};
}

}  // namespace

Result<TriangleMesh> flattened(std::span<const TriangleMesh> meshes, std::span<const Instance> instances) {
  std::uint64_t vertices = 0, triangles = 0;
  for (const Instance& instance : instances)
    vertices += meshes[instance.mesh].vertices.size(), triangles += meshes[instance.mesh].size();
  if (triangles > kMaxTriangles || vertices > std::numeric_limits<std::uint32_t>::max())
    return Error{"the instances have " + std::to_string(triangles) + " triangles and " + std::to_string(vertices) +
                 " vertices together, more than one mesh may have; trace them with a method for instances"};
  try {
    TriangleMesh flat{Buffer<Vec3>(vertices), Buffer<IndexTriple>(triangles)};
    std::uint32_t first_vertex = 0;
    IndexTriple* triangle = flat.triangles.begin();
    for (const Instance& instance : instances) {
      const TriangleMesh& mesh = meshes[instance.mesh];
      std::transform(mesh.vertices.begin(), mesh.vertices.end(), flat.vertices.begin() + first_vertex,
                     [&](Vec3 v) { return placed(instance.transform, v); });
      for (const IndexTriple& t : mesh.triangles) *triangle++ = {first_vertex + t.v0, first_vertex + t.v1, first_vertex + t.v2};
      first_vertex += static_cast<std::uint32_t>(mesh.vertices.size());
    }
    return flat;
  } catch (const std::bad_alloc&) {
    return Error{"not enough memory for the " + std::to_string(triangles) + " triangles of all instances"};
  }
}

struct InstancedMeshes::Flat {
  std::mutex mutex;
  std::optional<TriangleMesh> mesh;
};

std::shared_ptr<InstancedMeshes::Flat> InstancedMeshes::make_flat() { return std::make_shared<Flat>(); }

Result<InstancedMeshes> InstancedMeshes::place(std::shared_ptr<const Meshes> meshes, std::vector<Instance> instances) {
  const auto name = [](std::size_t i) { return "instance " + std::to_string(i + 1); };
  auto parts = std::make_shared<Parts>();
  parts->first_prims.reserve(instances.size());
  for (std::size_t i = 0; i < instances.size(); ++i) {
    if (const Status good = check_instance(instances[i], meshes->bounds); !good) return Error{name(i) + ": " + good.message()};
    parts->first_prims.push_back(static_cast<std::uint32_t>(parts->size));
    parts->size += meshes->meshes[instances[i].mesh].size();
    if (parts->size > kNoHit)
      return Error{name(i) + ": its triangles and those before it are more than the 2^32 - 1 that prim_ids can name"};
  }
  parts->placed = std::move(meshes), parts->instances = std::move(instances);
  return InstancedMeshes(std::move(parts));
}

Result<InstancedMeshes> InstancedMeshes::make(std::vector<TriangleMesh> meshes, std::vector<Instance> instances) try {
  auto checked = std::make_shared<Meshes>();
  for (const TriangleMesh& mesh : meshes) {
    if (const Status valid = validate(mesh); !valid) return valid.error();
    checked->bounds.push_back(bounds_of(mesh));
  }
  checked->meshes = std::move(meshes);
  return place(std::move(checked), std::move(instances));
} catch (const std::bad_alloc&) {
  return out_of_memory("putting a scene of instances together");
}

Result<InstancedMeshes> InstancedMeshes::with_instances(std::vector<Instance> instances) const try {
  return place(state_->placed, std::move(instances));
} catch (const std::bad_alloc&) {
  return out_of_memory("placing instances");
}

std::size_t InstancedMeshes::size_bytes() const {
  std::size_t bytes = instances().size_bytes();
  for (const TriangleMesh& mesh : meshes()) bytes += mesh.size_bytes();
  return bytes;
}

bool InstancedMeshes::is_better_apart() const {
  std::uint64_t of_meshes = 0;
  for (const TriangleMesh& mesh : meshes()) of_meshes += mesh.size();
  return are_better_apart(size(), of_meshes);
}

InstancedMeshes::Place InstancedMeshes::place_of(std::uint32_t prim_id) const {
  ACCEL_ASSERT(prim_id < size());
  // The last instance that begins at or before it: those without triangles begin where the next one does.
  const auto& firsts = state_->first_prims;
  const auto next = std::upper_bound(firsts.begin(), firsts.end(), prim_id);
  const auto instance = static_cast<std::uint32_t>(next - firsts.begin() - 1);
  return {instance, prim_id - firsts[instance]};
}

Triangle InstancedMeshes::triangle(std::uint32_t prim_id) const {
  const Place place = place_of(prim_id);
  const Instance& instance = state_->instances[place.instance];
  const Triangle t = meshes()[instance.mesh].triangle(place.triangle);
  return {placed(instance.transform, t.v0), placed(instance.transform, t.v1), placed(instance.transform, t.v2)};
}

double InstancedMeshes::position_error(std::uint32_t prim_id) const {
  const Affine& m = state_->instances[place_of(prim_id).instance].transform;
  const AffineInverse inverse = *accel::inverse(m);
  const Triangle t = triangle(prim_id);
  double reach[3] = {0, 0, 0}, largest = 0;
  for (const Vec3 v : {t.v0, t.v1, t.v2})
    for (int a = 0; a < 3; ++a) {
      reach[a] = std::fmax(reach[a], std::fabs(double{v[a]} - m.m[a][3]));
      largest = std::fmax(largest, std::fabs(double{v[a]}));
    }
  double moved = 0;
  for (const auto& row : m.m) {
    double along = 0;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) along += std::fabs(row[i] * inverse.linear[i][j]) * reach[j];
    moved = std::fmax(moved, along);
  }
  return static_cast<double>(gamma(6 + 2 * 16)) * moved + kUnitRoundoff * largest;
}

Result<TriangleMesh> InstancedMeshes::flattened() const {
  const std::lock_guard lock(state_->flat->mutex);
  if (!state_->flat->mesh) {
    Result<TriangleMesh> mesh = accel::flattened(meshes(), instances());
    if (!mesh) return mesh;
    state_->flat->mesh = *std::move(mesh);
  }
  return *state_->flat->mesh;
}

}  // namespace accel
