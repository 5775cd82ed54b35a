#include "apps/common/trace_pictures.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace accel::apps {

namespace {

using validation::Verdict;

// From harmless to grave; as displayed.
struct VerdictClass {
  Verdict verdict;
  const char* name;
  Vec3 color;
};
constexpr VerdictClass kClasses[] = {
    {Verdict::unjudged, "not judged", {0.30f, 0.30f, 0.32f}}, {Verdict::agree, "agree", {0.16f, 0.24f, 0.34f}},
    {Verdict::right, "right", {0.35f, 0.72f, 0.45f}},         {Verdict::neighbour, "neighbour", {0.25f, 0.65f, 0.95f}},
    {Verdict::edge, "edge", {0.98f, 0.83f, 0.30f}},           {Verdict::far, "far", {0.98f, 0.52f, 0.18f}},
    {Verdict::false_hit, "false", {0.90f, 0.30f, 0.85f}},     {Verdict::miss, "miss", {1.00f, 0.12f, 0.12f}}};
constexpr std::uint8_t kNoRays = static_cast<std::uint8_t>(std::size(kClasses));

std::uint8_t class_of(Verdict verdict) {
  const auto found =
      std::find_if(std::begin(kClasses), std::end(kClasses), [&](const VerdictClass& c) { return c.verdict == verdict; });
  return static_cast<std::uint8_t>(found - std::begin(kClasses));
}

// The distance of two answers' t in units in the last place; where only one of them hits, the largest float.
float ulp_distance(const Hit& a, const Hit& b) {
  if (a.valid() != b.valid()) return std::numeric_limits<float>::max();
  if (!a.valid() || a.t == b.t) return 0;
  const float ulp = std::nextafter(std::max(a.t, b.t), std::numeric_limits<float>::infinity()) - std::max(a.t, b.t);
  return std::abs(a.t - b.t) / ulp;
}

// How far our answer to a ray is from the other one.
float distance(const Difference& d, std::size_t ray) {
  if (d.batch.query == Query::any) {
    if (d.witness.occluded.empty()) return 0;
    return (d.ours.occluded[ray] != 0) != (d.witness.occluded[ray] != 0) ? std::numeric_limits<float>::max() : 0;
  }
  if (!d.witness.hits.empty()) return ulp_distance(d.ours.hits[ray], d.witness.hits[ray]);
  const auto exact = d.judge.oracle().closest(d.batch.rays()[ray]);
  const Hit hit{static_cast<float>(exact.t), 0, 0, exact.valid() ? exact.prims.front() : kNoHit};
  return ulp_distance(d.ours.hits[ray], hit);
}

}  // namespace

HeatPicture heat_picture(std::span<const std::uint32_t> values, RayCounter counter, const RaySet& set, PictureSize size,
                         const std::string& subject) {
  HeatPicture picture = mean_by_pixel(values, set, size);
  picture.title = subject;
  picture.unit = std::string(counter_unit(counter)) + " / ray";
  return picture;
}

ClassPicture verdicts_picture(const validation::CheckResult& check, const RaySet& set, PictureSize size) {
  ClassPicture picture{size, {}, std::vector<std::uint8_t>(size.pixels(), kNoRays), "verdicts"};
  for (const VerdictClass& c : kClasses) picture.classes.push_back({c.name, c.color});
  picture.classes.push_back({"no rays", {0.22f, 0.22f, 0.25f}});
  for (std::size_t i = 0; i < check.verdicts.size(); ++i) {
    const std::uint8_t mine = class_of(check.verdicts[i]);
    ++picture.classes[mine].rays;
    std::uint8_t& gravest = picture.values[set.pixel[i]];
    gravest = gravest == kNoRays ? mine : std::max(gravest, mine);
  }
  return picture;
}

DifferencePictures difference_pictures(const Difference& d, PictureSize size, const std::string& subject) {
  DifferencePictures pictures;
  pictures.distance = {size, std::vector<float>(size.pixels(), std::numeric_limits<float>::quiet_NaN()),
                       std::string("t against ") + (d.check.has_witness ? "Embree robust" : "exact") + ": " + subject, "ulp"};
  pictures.verdicts = verdicts_picture(d.check, d.batch.set, size);
  for (std::size_t i = 0; i < d.batch.size(); ++i) {
    float& far_apart = pictures.distance.values[d.batch.set.pixel[i]];
    far_apart = std::fmax(far_apart, distance(d, i));
  }
  return pictures;
}

}  // namespace accel::apps
