#include "apps/common/ray_batch.h"

#include <algorithm>
#include <filesystem>

#include "libaccel/io/npy.h"
#include "libaccel/rays/camera.h"

namespace accel::apps {

namespace {

std::string file_name(const std::string& path) { return std::filesystem::path(path).filename().string(); }

// Named for the file; as the user wrote it where there is another of that name.
Outcome<RayBatch> read_batch(const std::string& path, const std::vector<std::string>& kinds) {
  auto rays = read_rays_npy(path);
  if (!rays) return rays.error();
  const auto is_namesake = [&](const std::string& other) { return file_name(other) == file_name(path); };
  const bool is_alone = std::count_if(kinds.begin(), kinds.end(), is_namesake) <= 1;
  return RayBatch{is_alone ? file_name(path) : path, Query::closest, RaySet{*std::move(rays), {}}};
}

}  // namespace

std::uint64_t most_rays(const TraceSettings& settings, const std::string& name) {
  if (name.ends_with(".npy")) {
    const auto rays = count_rays_npy(name);
    return rays ? *rays : 0;
  }
  const auto kind = parse_ray_kind(name);
  if (!kind) return 0;
  const std::uint64_t pixels = std::uint64_t{settings.width} * settings.height;
  if (!info(*kind).is_image) return settings.count > 0 ? settings.count : pixels;
  return pixels * settings.spp * (*kind == RayKind::soft_shadow ? kSoftShadowSamples : 1);
}

bool rays_need_mesh(const std::string& name) {
  const auto kind = parse_ray_kind(name);
  return !name.ends_with(".npy") && kind && *kind != RayKind::primary && *kind != RayKind::random;
}

Outcome<RayMaker> RayMaker::create(const Scene& scene, const TraceSettings& settings, AnyAccel tracer) {
  auto camera = choose_camera(scene, settings.camera);
  if (!camera) return camera.failure();
  return RayMaker(scene, settings, std::move(tracer), *std::move(camera));
}

Outcome<RayBatch> RayMaker::make(const std::string& name) {
  auto batch = name.ends_with(".npy") ? read_batch(name, settings_->ray_kinds) : make_kind(name);
  if (batch && settings_->query) batch->query = *settings_->query;
  return batch;
}

Outcome<RayBatch> RayMaker::make_kind(const std::string& name) {
  const auto kind = parse_ray_kind(name);
  if (!kind) return kind.error();
  auto rays = rays_of(*kind);
  if (!rays) return rays.error();
  return RayBatch{name, info(*kind).query, *std::move(rays)};
}

Outcome<RayMaker::View> RayMaker::view() {
  if (const Status made = make_hits(); !made) return made.error();
  return View{*primary_, hits_.span()};
}

Result<RaySet> RayMaker::rays_of(RayKind kind) {
  const std::uint64_t count = settings_->count > 0 ? settings_->count : picture_size().pixels();
  if (kind == RayKind::random) return random_rays(scene_->facts.bounds, count, settings_->common.seed);
  if (kind == RayKind::edge) return edge_rays(scene_->triangles(), count, settings_->common.seed);
  if (const Status made = make_primary(); !made) return made.error();
  if (kind == RayKind::primary) return *primary_;
  if (const Status made = make_hits(); !made) return made.error();
  const PrimaryHits from{scene_->triangles(), *primary_, hits_.span()};
  return secondary_rays(kind, from, choose_light(*scene_, camera_), settings_->common.seed);
}

Status RayMaker::make_primary() {
  if (primary_) return Done{};
  const auto camera = Camera::make(camera_, settings_->width, settings_->height);
  if (!camera) return camera.error();
  auto rays = primary_rays(*camera, settings_->spp, settings_->common.seed, settings_->pixel_order);
  if (!rays) return rays.error();
  primary_ = *std::move(rays);
  return Done{};
}

Status RayMaker::make_hits() {
  if (Status made = make_primary(); !made || hits_.size() == primary_->size()) return made;
  hits_ = Buffer<Hit>(primary_->size());
  return tracer_.closest(primary_->rays.span(), hits_.span(), {settings_->common.threads, {}});
}

}  // namespace accel::apps
