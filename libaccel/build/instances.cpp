#include "libaccel/build/instances.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <vector>

#include "libaccel/build/object_splitter.h"
#include "libaccel/build/sbvh.h"
#include "libaccel/core/float_bounds.h"
#include "libaccel/structure/padding.h"

namespace accel {
namespace {

// Boxes of a mesh's tree that together contain its triangles.
constexpr std::size_t kFrontier = 32;

// A box in double, and empty as Aabb is.
struct WideBox {
  Vec3d lo{INFINITY, INFINITY, INFINITY}, hi{-INFINITY, -INFINITY, -INFINITY};

  void extend(const WideBox& b) {
    lo = {std::fmin(lo.x, b.lo.x), std::fmin(lo.y, b.lo.y), std::fmin(lo.z, b.lo.z)};
    hi = {std::fmax(hi.x, b.hi.x), std::fmax(hi.y, b.hi.y), std::fmax(hi.z, b.hi.z)};
  }
  bool empty() const { return !(lo.x <= hi.x); }
};

// The boxes of the nodes that a search in breadth comes to before there are more than kFrontier.
std::vector<Aabb> frontier(const Bvh2& bvh) {
  struct Entry {
    NodeRef node;
    Aabb box;
  };
  std::vector<Entry> entries;
  if (bvh.root != kNoNode) entries.push_back({bvh.root, bvh.bounds});
  for (bool grows = true; grows && 2 * entries.size() <= kFrontier;) {
    std::vector<Entry> next;
    for (const Entry& entry : entries) {
      if (is_leaf(entry.node)) {
        next.push_back(entry);
        continue;
      }
      const Bvh2Node& node = bvh.nodes[entry.node];
      for (int c = 0; c < 2; ++c) next.push_back({node.child[c], node.bounds(c)});
    }
    grows = next.size() > entries.size();
    entries = std::move(next);
  }
  std::vector<Aabb> boxes;
  for (const Entry& entry : entries) boxes.push_back(entry.box);
  return boxes;
}

// The box that contains the map of a box: per axis, the sums of the smaller and of the larger products.
WideBox placed_box(const Affine& transform, const Aabb& box) {
  double lo[3], hi[3];
  for (int a = 0; a < 3; ++a) {
    lo[a] = hi[a] = transform.m[a][3];
    for (int b = 0; b < 3; ++b) {
      const double m = transform.m[a][b], from = m * box.lo[b], to = m * box.hi[b];
      lo[a] += std::fmin(from, to), hi[a] += std::fmax(from, to);
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
TriangleMesh stand_ins(const std::vector<WideBox>& boxes, const Buffer<TwoLevelInstance>& instances,
                       const InstancedMeshes& scene) {
  WideBox all;
  for (const WideBox& box : boxes) all.extend(box);
  TriangleMesh mesh{Buffer<Vec3>(2 * boxes.size()), Buffer<IndexTriple>(boxes.size())};
  for (std::uint32_t i = 0; i < boxes.size(); ++i) {
    const Aabb box = boxes[i].empty()
                         ? Aabb{}
                         : rounded_box(boxes[i], padding_of(scene.instances()[i].transform, instances[i].to_object, all));
    mesh.vertices[2 * i] = box.lo, mesh.vertices[2 * i + 1] = box.hi;
    mesh.triangles[i] = {2 * i, 2 * i + 1, 2 * i + 1};
  }
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

Result<Built<Bvh2>> build_over_instances(const TriangleMesh& stand_in_mesh, BuildOptions options) {
  options.max_leaf_size = 1;
  return run_build<Bvh2>(stand_in_mesh, options, [](BuildContext& context) -> Result<Bvh2> {
    References references = references_to(context.mesh);
    if (references.count == 0) return Bvh2{};
    context.memory.add(references.storage.size_bytes());
    const ObjectSplitter splitter(references.storage.data(), context.options);
    return build_bvh2(context, splitter, references);
  });
}

// A build in its parts, whose reports add up.
class Builder {
 public:
  Builder(const InstancedMeshes& scene, const BuildOptions& options) : scene_(scene), options_(options) {}

  Result<Built<TwoLevelBvh>> run() {
    for (const TriangleMesh& mesh : scene_.meshes()) all_ += mesh.size();
    trees_.emplace_back();  // the one over instances comes first, and is built last
    triangles_.push_back(scene_.instances().size());
    for (const TriangleMesh& mesh : scene_.meshes())
      if (const Status built = build_mesh(mesh); !built) return built.error();
    place_instances();
    if (const Status built = build_top(); !built) return built.error();

    TwoLevelBvh bvh = TwoLevelBvh::join(trees_, triangles_);
    bvh.instances = instances_;
    report_.peak_bytes = std::max<std::uint64_t>(report_.peak_bytes, held_ + bvh.size_bytes());
    const std::uint64_t stored = report_.triangles;
    report_.notes.push_back({"instances", std::to_string(scene_.instances().size()) + " of " +
                                              std::to_string(scene_.meshes().size()) + " meshes: " + std::to_string(stored) +
                                              " triangles are stored, for " + std::to_string(scene_.size()) + " in the scene"});
    return Built<TwoLevelBvh>{std::move(bvh), std::move(report_)};
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kTellingInterval{100};

  // Tells the caller how much of all meshes is done, not each of the phases of each of them, which begin anew.
  Progress progress_of(const TriangleMesh& mesh) {
    return [this, &mesh](std::string_view, double fraction) {
      const auto now = Clock::now();
      if (now - last_told_ < kTellingInterval) return true;
      last_told_ = now;
      const double of_all =
          (static_cast<double>(done_) + fraction * static_cast<double>(mesh.size())) / static_cast<double>(all_);
      told_ = std::max(told_, of_all);
      return options_.progress("meshes", told_);
    };
  }

  Status build_mesh(const TriangleMesh& mesh) {
    BuildOptions options = options_;
    if (options.progress) options.progress = progress_of(mesh);
    Result<Built<Bvh2>> built = Sbvh::build(mesh, options);
    done_ += mesh.size();
    if (!built) return built.error();
    report_.triangles += built->report.triangles, report_.references += built->report.references;
    report_.skipped.zero_area += built->report.skipped.zero_area;
    report_.skipped.out_of_range += built->report.skipped.out_of_range;
    take(*std::move(built), mesh.size(), "meshes");
    return Done{};
  }

  void place_instances() {
    instances_ = Buffer<TwoLevelInstance>(scene_.instances().size());
    std::vector<std::vector<Aabb>> frontiers;
    for (std::size_t tree = 1; tree < trees_.size(); ++tree) frontiers.push_back(frontier(trees_[tree]));
    for (std::size_t i = 0; i < instances_.size(); ++i) {
      const Instance& instance = scene_.instances()[i];
      instances_[i] = {*inverse(instance.transform), instance.mesh + 1, scene_.first_prim(i), {0, 0}};
      boxes_.push_back(placed_boxes(instance.transform, frontiers[instance.mesh]));
    }
  }

  Status build_top() {
    const TriangleMesh mesh = stand_ins(boxes_, instances_, scene_);
    Result<Built<Bvh2>> built = build_over_instances(mesh, options_);
    if (!built) return built.error();
    trees_.front() = std::move(built->structure);
    add_phase("instances", built->report.seconds);
    return Done{};
  }

  void take(Built<Bvh2> built, std::uint64_t triangles, const std::string& phase) {
    report_.peak_bytes = std::max(report_.peak_bytes, held_ + built.report.peak_bytes);
    held_ += built.structure.size_bytes();
    add_phase(phase, built.report.seconds);
    trees_.push_back(std::move(built.structure));
    triangles_.push_back(triangles);
  }

  // Phases of one name count as one.
  void add_phase(const std::string& name, double seconds) {
    if (report_.phases.empty() || report_.phases.back().name != name) report_.phases.push_back({name, 0});
    report_.phases.back().seconds += seconds;
    report_.seconds += seconds;
  }

  const InstancedMeshes& scene_;
  const BuildOptions& options_;
  std::vector<Bvh2> trees_;
  std::vector<std::uint64_t> triangles_;
  Buffer<TwoLevelInstance> instances_;
  std::vector<WideBox> boxes_;        // of the instances
  std::uint64_t held_ = 0;            // bytes of the trees so far
  std::uint64_t done_ = 0, all_ = 0;  // triangles of meshes
  Clock::time_point last_told_{};
  double told_ = 0;
  BuildReport report_;
};

}  // namespace

Result<Built<TwoLevelBvh>> InstanceBuilder::build(const InstancedMeshes& scene, const BuildOptions& options) {
  if (const Status good = validate(options); !good) return good.error();
  try {
    return Builder(scene, options).run();
  } catch (const std::bad_alloc&) {
    return Error{"out of memory while building a structure over " + std::to_string(scene.instances().size()) + " instances"};
  }
}

}  // namespace accel
