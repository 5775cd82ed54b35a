// The rays of a run: one batch for each kind or file named by --rays.
#pragma once

#include <optional>
#include <string>

#include "apps/common/failure.h"
#include "apps/common/picture.h"
#include "apps/common/scene.h"
#include "apps/common/trace_options.h"
#include "libaccel/core/hit.h"
#include "libaccel/rays/ray_sets.h"
#include "libaccel/registry/any_accel.h"

namespace accel::apps {

struct RayBatch {
  std::string name;              // "soft-shadow", "mine.npy"
  Query query = Query::closest;  // what renderers ask of such rays, or the user does
  RaySet set;

  std::span<const Ray> rays() const { return set.rays.span(); }
  std::size_t size() const { return set.size(); }
};

// The most rays that the batch of a kind may have, and how many a .npy file has: 0 where it cannot be read.
std::uint64_t most_rays(const TraceSettings& settings, const std::string& name);

// Whether making the rays that --rays calls `name` needs the scene's triangles.
bool rays_need_mesh(const std::string& name);

// Makes batches. Primary rays and their hits are kept, since the secondary kinds start from them; they are made when first
// needed.
class RayMaker {
 public:
  // The scene and settings outlive the maker. `tracer` finds the hits that secondary rays start from.
  static Outcome<RayMaker> create(const Scene& scene, const TraceSettings& settings, AnyAccel tracer);

  // The batch for a name that --rays accepts.
  Outcome<RayBatch> make(const std::string& name);

  PictureSize picture_size() const { return {settings_->width, settings_->height}; }
  const CameraDescription& camera() const { return camera_; }

  // The primary rays and their hits.
  struct View {
    const RaySet& rays;
    std::span<const Hit> hits;
  };
  Outcome<View> view();

 private:
  RayMaker(const Scene& scene, const TraceSettings& settings, AnyAccel tracer, CameraDescription camera)
      : scene_(&scene), settings_(&settings), tracer_(std::move(tracer)), camera_(std::move(camera)) {}

  Outcome<RayBatch> make_kind(const std::string& name);
  Result<RaySet> rays_of(RayKind kind);
  Status make_primary();
  Status make_hits();

  const Scene* scene_;
  const TraceSettings* settings_;
  AnyAccel tracer_;
  CameraDescription camera_;
  std::optional<RaySet> primary_;
  Buffer<Hit> hits_;
};

}  // namespace accel::apps
