// Embree's scenes of a run, each built when it is first needed.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "apps/common/common_settings.h"
#include "apps/common/progress_bar.h"
#include "apps/common/scene.h"
#include "validation/oracle/embree.h"

namespace accel::apps {

// What a method traces: the scene as it is, or its instances as one mesh.
enum class Truth { as_it_is, one_mesh };

class EmbreeScenes {
 public:
  // All of them outlive the scenes.
  EmbreeScenes(const Scene& scene, const CommonSettings& settings, ProgressBar& bar)
      : scene_(&scene), settings_(&settings), bar_(&bar) {}

  // Valid as long as this object is.
  Result<const validation::EmbreeWitness*> get(validation::EmbreeMode mode, validation::EmbreeQuality quality, Truth truth);

  // "Embree 3.13.5 (avx2)", or empty where none has been built.
  std::string name() const;

 private:
  struct Built {
    Truth truth;
    std::unique_ptr<validation::EmbreeWitness> scene;
  };

  const Scene* scene_;
  const CommonSettings* settings_;
  ProgressBar* bar_;
  std::vector<Built> built_;
};

}  // namespace accel::apps
