#include "apps/common/build_run.h"

#include <tbb/info.h>

#include <algorithm>

#include "libaccel/registry/accel_files.h"

namespace accel::apps {

namespace {

// Zeros stand for a resolution that the builder chooses.
std::string resolution_text(const int (&cells)[3]) {
  return std::to_string(cells[0]) + "x" + std::to_string(cells[1]) + "x" + std::to_string(cells[2]);
}

std::map<std::string, std::string> option_texts(const BuildOptions& options) {
  const auto text = [](double value) { return std::to_string(value); };
  return {{"traversal_cost", text(options.traversal_cost)},
          {"intersection_cost", text(options.intersection_cost)},
          {"bins", std::to_string(options.bins)},
          {"max_leaf_size", std::to_string(options.max_leaf_size)},
          {"max_depth", std::to_string(options.max_depth)},
          {"spatial_overlap", text(options.spatial_overlap)},
          {"max_duplication", text(options.max_duplication)},
          {"reinsertion_rounds", std::to_string(options.reinsertion_rounds)},
          {"reinsertion_seconds", text(options.reinsertion_seconds)},
          {"grid_resolution", resolution_text(options.grid_resolution)},
          {"grid_density", text(options.grid_density)},
          {"empty_bonus", text(options.empty_bonus)},
          {"max_references", text(options.max_references)}};
}

// What was built, not how the build went: times and peaks of memory would make other bytes of the same structure each time.
AccelMetadata metadata_of(const Scene& scene, const StructureFacts& facts, const BuildOptions& options) {
  AccelMetadata metadata;
  metadata.scene = scene.name;
  metadata.options = option_texts(options);
  if (scene.skipped_faces > 0) metadata.statistics["skipped_faces"] = static_cast<double>(scene.skipped_faces);
  if (facts.sah_cost) metadata.statistics["sah_cost"] = *facts.sah_cost;
  metadata.cameras = scene.data.cameras;
  metadata.light = scene.data.light;
  return metadata;
}

}  // namespace

Outcome<BuildRunReport> run_build(const BuildSettings& settings, ProgressBar& bar) {
  bar.begin("loading " + settings.scene);
  auto scene = open_scene(settings.scene, settings.common.seed, bar.callback());
  if (!scene) return scene.failure();

  const std::string method =
      settings.method.empty() ? best_method({.instances = scene->data.is_better_apart()}) : settings.method;
  bar.begin("building " + builder_of(method));
  BuildOptions options = settings.build;
  options.progress = bar.callback();
  const auto accel = scene->data.instances ? AnyAccel::build(*scene->data.instances, method, options)
                                           : AnyAccel::build(scene->data.mesh, method, options);
  if (!accel) return accel.error();

  const StructureFacts facts = facts_of(accel->structure(), options, settings.stats ? Detail::all : Detail::quick);
  if (!settings.output.empty()) {
    bar.begin("writing " + settings.output);
    const AccelMetadata metadata = metadata_of(*scene, facts, options);
    const Status saved = scene->data.instances ? save_accel(settings.output, *accel, *scene->data.instances, metadata)
                                               : save_accel(settings.output, *accel, scene->data.mesh, metadata);
    if (!saved) return saved.error();
  }
  const int threads = settings.common.threads > 0 ? settings.common.threads : tbb::info::default_concurrency();
  return BuildRunReport{scene->name,
                        accel->method().builder,
                        accel->method().structure,
                        scene->triangles().size(),
                        scene->skipped_faces,
                        scene->data.size_bytes(),
                        accel->size_bytes(),
                        scene->load_seconds,
                        threads,
                        accel->report(),
                        facts,
                        settings.output};
}

}  // namespace accel::apps
