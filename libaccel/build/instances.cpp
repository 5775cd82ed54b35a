#include "libaccel/build/instances.h"

#include <algorithm>
#include <chrono>
#include <string>
#include <vector>

#include "libaccel/build/build_context.h"
#include "libaccel/build/sbvh.h"
#include "libaccel/build/top_level.h"

namespace accel {
namespace {

// For each triangle of a mesh: 3 % of a build's time.
constexpr double kBoxesPerTriangle = 4;

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
    if (const Status built = build_top(); !built) return built.error();

    TwoLevelBvh bvh = TwoLevelBvh::join(trees_, triangles_);
    bvh.instances = instances_;
    report_.peak_bytes = std::max<std::uint64_t>(report_.peak_bytes, held_ + bvh.size_bytes());
    report_.notes.push_back(instances_note(scene_, report_.triangles));
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

  Status build_top() {
    const auto start = Clock::now();
    const std::size_t most = boxes_an_instance(scene_, kBoxesPerTriangle);
    std::vector<std::vector<Aabb>> boxes;
    for (std::size_t i = 1; i < trees_.size(); ++i)
      boxes.push_back(boxes_below(trees_[i].nodes.data(), trees_[i].root, trees_[i].bounds, most));
    const std::vector<AffineInverse> to_object = inverses(scene_.instances());
    Result<Built<Bvh2>> built = build_top_level(scene_, to_object, boxes, options_);
    if (!built) return built.error();
    report_.peak_bytes = std::max(report_.peak_bytes, held_ + built->report.peak_bytes);
    trees_.front() = std::move(built->structure);
    instances_ = Buffer<TwoLevelInstance>(to_object.size());
    for (std::size_t i = 0; i < to_object.size(); ++i)
      instances_[i] = {to_object[i], scene_.instances()[i].mesh + 1, scene_.first_prim(i), {0, 0}};
    add_phase("instances", std::chrono::duration<double>(Clock::now() - start).count());
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
