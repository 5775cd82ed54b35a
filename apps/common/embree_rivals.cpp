#include "apps/common/embree_rivals.h"

#include <algorithm>

#include "libaccel/core/morton.h"
#include "libaccel/packet/cpu_primitives.h"
#include "libaccel/packet/ray_order.h"

namespace accel::apps {

using validation::EmbreeCalls;
using validation::EmbreeMode;
using validation::EmbreeQuality;
using validation::EmbreeWitness;

Engine engine_of(const EmbreeTimed& timed, const EmbreeWitness& scene, int threads) {
  Engine engine;
  engine.name = row_name(timed);
  engine.closest = [&scene, threads, calls = timed.calls](std::span<const Ray> rays, std::span<Hit> hits) {
    return scene.time_closest(calls, rays, hits, threads);
  };
  engine.occluded = [&scene, threads, calls = timed.calls](std::span<const Ray> rays, std::span<std::uint8_t> occluded) {
    return scene.time_occluded(calls, rays, occluded, threads);
  };
  return engine;
}

namespace {

bool is_asked_for(const EmbreeTimed& timed, const std::vector<std::string>& names) {
  return &timed == &kEmbreeModes[0] ||
         std::any_of(names.begin(), names.end(), [&](const std::string& name) { return name == timed.name || name == "all"; });
}

}  // namespace

Outcome<std::vector<EmbreeRival>> make_rivals(EmbreeScenes& scenes, const TraceSettings& settings, Truth truth,
                                              std::vector<Skip>& skipped) {
  std::vector<EmbreeRival> rivals;
  if (!EmbreeWitness::available()) {
    if (settings.embree.empty()) return rivals;
    return Failure(ExitStatus::unavailable, "--embree: " + EmbreeWitness::version());
  }
  if (settings.embree.empty() && settings.check != Check::embree) return rivals;
  for (const EmbreeTimed& timed : kEmbreeModes) {
    if (!is_asked_for(timed, settings.embree)) continue;
    const auto scene = scenes.get(timed.mode, timed.quality, truth);
    if (!scene) return scene.error();
    if (const Status possible = (*scene)->can(timed.calls); !possible) {
      const auto& names = settings.embree;
      if (std::find(names.begin(), names.end(), timed.name) != names.end())
        return Failure(ExitStatus::unavailable, "--embree " + std::string(timed.name) + ": " + possible.message());
      skipped.push_back({row_name(timed), possible.message()});
      continue;
    }
    rivals.push_back({&timed, *scene, engine_of(timed, **scene, settings.common.threads)});
  }
  return rivals;
}

std::string row_name(const EmbreeTimed& timed) {
  return &timed == &kEmbreeModes[0] ? "Embree" : "Embree/" + std::string(timed.name);
}

std::string structure_name(const EmbreeWitness& scene) {
  constexpr const char* kQualities[] = {"low", "medium", "high"};
  const auto& options = scene.options();
  return std::string("Embree (") + kQualities[static_cast<int>(options.quality)] + ", " +
         (options.mode == EmbreeMode::fast ? "fast" : "robust") + ")";
}

Buffer<Ray> by_tiles(const RaySet& set, std::uint32_t width) {
  if (set.pixel.empty()) return {};
  const std::size_t n = set.size();
  Buffer<std::uint64_t> codes(n);
  Buffer<std::uint32_t> order(n);
  for (std::size_t i = 0; i < n; ++i) {
    codes[i] = morton_2d(set.pixel[i] % width, set.pixel[i] / width);
    order[i] = static_cast<std::uint32_t>(i);
  }
  CpuPrimitives::sort_pairs(codes.data(), order.data(), n);
  Buffer<Ray> rays(n);
  gather_rays(set.rays.span(), order.span(), rays.span());
  return rays;
}

}  // namespace accel::apps
