#include "libaccel/build/top_level.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <string>

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "libaccel/build/object_splitter.h"
#include "libaccel/core/float_bounds.h"
#include "libaccel/core/threads.h"
#include "libaccel/structure/padding.h"

namespace accel {
namespace {

// Of numbers; an instruction each, where std::fmin and std::fmax are calls.
double lesser(double a, double b) { return a < b ? a : b; }
double greater(double a, double b) { return a > b ? a : b; }

// A box in double, and empty as Aabb is.
struct WideBox {
  Vec3d lo{INFINITY, INFINITY, INFINITY}, hi{-INFINITY, -INFINITY, -INFINITY};

  void extend(const WideBox& b) {
    lo = {lesser(lo.x, b.lo.x), lesser(lo.y, b.lo.y), lesser(lo.z, b.lo.z)};
    hi = {greater(hi.x, b.hi.x), greater(hi.y, b.hi.y), greater(hi.z, b.hi.z)};
  }
  bool empty() const { return !(lo.x <= hi.x); }
};

// The box that contains the map of a box: per axis, the sums of the smaller and of the larger products.
WideBox placed_box(const Affine& transform, const Aabb& box) {
  double lo[3], hi[3];
  for (int a = 0; a < 3; ++a) {
    lo[a] = hi[a] = transform.m[a][3];
    for (int b = 0; b < 3; ++b) {
      const double m = transform.m[a][b], from = m * box.lo[b], to = m * box.hi[b];
      lo[a] += lesser(from, to), hi[a] += greater(from, to);
    }
  }
  return {{lo[0], lo[1], lo[2]}, {hi[0], hi[1], hi[2]}};
}

WideBox placed_boxes(const Affine& transform, const std::vector<Aabb>& boxes) {
  WideBox result;
  for (const Aabb& box : boxes) result.extend(placed_box(transform, box));
  return result;
}

// The pad that the header derives, for an instance in a scene with this box. The products are rounded in double, which the
// last gamma has room for.
Vec3d padding_of(const Affine& transform, const AffineInverse& inverse, const WideBox& scene) {
  const Vec3d size = scene.hi - scene.lo;
  const double reach = kPaddingReach * std::fmax(size.x, std::fmax(size.y, size.z));
  const Vec3d from = scene.lo - Vec3d(inverse.origin), to = scene.hi - Vec3d(inverse.origin);
  const double w[3] = {std::fmax(std::fabs(from.x), std::fabs(to.x)) + reach,
                       std::fmax(std::fabs(from.y), std::fabs(to.y)) + reach,
                       std::fmax(std::fabs(from.z), std::fabs(to.z)) + reach};
  double pad[3] = {0, 0, 0};
  for (int i = 0; i < 3; ++i) {
    double moved = 0;  // in the instance's space, along axis i
    for (int j = 0; j < 3; ++j) moved += std::fabs(inverse.linear[i][j]) * w[j];
    for (int a = 0; a < 3; ++a) pad[a] += std::fabs(transform.m[a][i]) * moved;
  }
  const double share = gamma(26);
  return {share * pad[0], share * pad[1], share * pad[2]};
}

// Rounded outwards, and within what floats can hold.
Aabb rounded_box(const WideBox& box, Vec3d pad) {
  constexpr double kLargest = std::numeric_limits<float>::max();
  const auto down = [&](double x) { return round_down(std::fmax(x, -kLargest)); };
  const auto up = [&](double x) { return round_up(std::fmin(x, kLargest)); };
  return {{down(box.lo.x - pad.x), down(box.lo.y - pad.y), down(box.lo.z - pad.z)},
          {up(box.hi.x + pad.x), up(box.hi.y + pad.y), up(box.hi.z + pad.z)}};
}

// The stand-in of each instance for the tree over them: its box from corner to corner. Empty boxes make empty triangles, whose
// lower corner is not below the upper one.
TriangleMesh stand_ins(const InstancedMeshes& scene, std::span<const AffineInverse> to_object,
                       std::span<const std::vector<Aabb>> mesh_boxes) {
  const std::span<const Instance> instances = scene.instances();
  std::vector<WideBox> boxes(instances.size());
  tbb::parallel_for(std::size_t{0}, boxes.size(),
                    [&](std::size_t i) { boxes[i] = placed_boxes(instances[i].transform, mesh_boxes[instances[i].mesh]); });
  WideBox all;
  for (const WideBox& box : boxes) all.extend(box);
  TriangleMesh mesh{Buffer<Vec3>(2 * boxes.size()), Buffer<IndexTriple>(boxes.size())};
  tbb::parallel_for(std::size_t{0}, boxes.size(), [&](std::size_t i) {
    const Aabb box = boxes[i].empty() ? Aabb{} : rounded_box(boxes[i], padding_of(instances[i].transform, to_object[i], all));
    const auto first = static_cast<std::uint32_t>(2 * i);
    mesh.vertices[first] = box.lo, mesh.vertices[first + 1] = box.hi;
    mesh.triangles[i] = {first, first + 1, first + 1};
  });
  return mesh;
}

// All stand-ins that are not empty. They are few beside the triangles: one thread is enough.
References references_to(const TriangleMesh& mesh) {
  References result;
  result.storage = Buffer<Reference>(mesh.size());
  for (std::uint32_t i = 0; i < mesh.size(); ++i) {
    const Vec3 lo = mesh.vertices[2 * i] + Vec3{}, hi = mesh.vertices[2 * i + 1] + Vec3{};  // no negative zeros
    if (Aabb{lo, hi}.empty()) continue;
    Reference& reference = result.storage[result.count++];
    reference = {lo, i, hi, 0};
    result.bounds.extend(reference.box());
  }
  return result;
}

}  // namespace

std::size_t boxes_an_instance(const InstancedMeshes& scene, double per_triangle) {
  double triangles = 0;
  for (const TriangleMesh& mesh : scene.meshes()) triangles += static_cast<double>(mesh.size());
  const double boxes = per_triangle * triangles / static_cast<double>(std::max<std::size_t>(scene.instances().size(), 1));
  return static_cast<std::size_t>(std::clamp(boxes, 32.0, 512.0));
}

BuildNote instances_note(const InstancedMeshes& scene, std::uint64_t stored_triangles) {
  return {"instances", std::to_string(scene.instances().size()) + " of " + std::to_string(scene.meshes().size()) +
                           " meshes: " + std::to_string(stored_triangles) + " triangles are stored, for " +
                           std::to_string(scene.size()) + " in the scene"};
}

std::vector<AffineInverse> inverses(std::span<const Instance> instances) {
  std::vector<AffineInverse> result;
  result.reserve(instances.size());
  for (const Instance& instance : instances) result.push_back(*inverse(instance.transform));
  return result;
}

Result<Built<Bvh2>> build_top_level(const InstancedMeshes& scene, std::span<const AffineInverse> to_object,
                                    std::span<const std::vector<Aabb>> mesh_boxes, const BuildOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  tbb::task_arena arena(arena_size(options.threads));
  const TriangleMesh mesh = arena.execute([&] { return stand_ins(scene, to_object, mesh_boxes); });
  BuildOptions of_tree = options;
  of_tree.max_leaf_size = 1;
  auto built = run_build<Bvh2>(mesh, of_tree, [](BuildContext& context) -> Result<Bvh2> {
    References references = references_to(context.mesh);
    if (references.count == 0) return Bvh2{};
    context.memory.add(references.storage.size_bytes());
    const ObjectSplitter splitter(references.storage.data(), context.options);
    return build_bvh2(context, splitter, references);
  });
  if (!built) return built;
  built->report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  built->report.peak_bytes += mesh.size_bytes() + to_object.size_bytes();
  return built;
}

}  // namespace accel
