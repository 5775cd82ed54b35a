// The pictures of a run that show numbers rather than the scene.
#pragma once

#include <span>
#include <string>

#include "apps/common/measure.h"
#include "apps/common/picture.h"
#include "apps/common/ray_batch.h"
#include "libaccel/exec/counters.h"
#include "validation/compare/compare.h"

namespace accel::apps {

// A counter by pixel, the mean of its rays; `subject` says of what.
HeatPicture heat_picture(std::span<const std::uint32_t> values, RayCounter counter, const RaySet& set, PictureSize size,
                         const std::string& subject);

// Our answers and the witness's (or, without a witness, the exact ones).
struct Difference {
  const RayBatch& batch;
  const Answers& ours;
  const Answers& witness;
  const validation::CheckResult& check;  // with its verdicts
  const validation::Judge& judge;
};

// The gravest verdict of each pixel's rays. The check has its verdicts.
ClassPicture verdicts_picture(const validation::CheckResult& check, const RaySet& set, PictureSize size);

struct DifferencePictures {
  HeatPicture distance;   // how far apart the t of both are, in ulp: the largest of a pixel's rays
  ClassPicture verdicts;  // the gravest verdict of a pixel's rays
};
DifferencePictures difference_pictures(const Difference& difference, PictureSize size, const std::string& subject);

}  // namespace accel::apps
