#include "apps/common/embree_scenes.h"

namespace accel::apps {

using validation::EmbreeMode;
using validation::EmbreeOptions;
using validation::EmbreeQuality;
using validation::EmbreeWitness;

namespace {

Result<EmbreeWitness> build(const Scene& scene, Truth truth, const EmbreeOptions& options) {
  if (scene.data.instances && truth == Truth::as_it_is) return EmbreeWitness::build(*scene.data.instances, options);
  const auto mesh = scene.data.one_mesh();
  return mesh ? EmbreeWitness::build(*mesh, options) : mesh.error();
}

}  // namespace

// Embree cannot be interrupted: looks before each of its builds.
Result<const EmbreeWitness*> EmbreeScenes::get(EmbreeMode mode, EmbreeQuality quality, Truth truth) {
  for (const Built& built : built_) {
    const EmbreeOptions& options = built.scene->options();
    if (built.truth == truth && options.mode == mode && options.quality == quality) return built.scene.get();
  }
  bar_->begin("building Embree");
  if (!bar_->update(mode == EmbreeMode::fast ? "fast" : "robust", 0)) return Error{std::string(kInterrupted)};
  auto made = build(*scene_, truth, {mode, quality, settings_->threads});
  if (!made) return made.error();
  built_.push_back({truth, std::make_unique<EmbreeWitness>(*std::move(made))});
  return built_.back().scene.get();
}

std::string EmbreeScenes::name() const {
  return built_.empty() ? std::string() : EmbreeWitness::version() + " (" + built_.front().scene->isa() + ")";
}

}  // namespace accel::apps
