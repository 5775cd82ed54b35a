#include "libaccel/packet/pixel_rows.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace accel {

namespace {

constexpr std::size_t kStep = 8, kShortest = 128;
constexpr std::size_t kGuesses = 3;  // rays that may tell of a length, since one may be alone at the edge of what is seen
constexpr std::size_t kWitnesses = 16, kMostDoubts = 3;  // rays that are asked about something, and how many may deny it
constexpr std::size_t kFewestRows = 8;                   // of which tiles could be made

// How far two rays are apart; NaN for those that nothing can trace.
class Distance {
 public:
  Distance(std::span<const Ray> rays, float scale) : rays_(rays), scale_(scale) {}

  float operator()(std::size_t i, std::size_t j) const {
    const Ray &a = rays_[i], &b = rays_[j];
    return scale_ * norm(a.org - b.org) + norm(a.dir - b.dir) / norm(a.dir);
  }

 private:
  static float norm(Vec3 v) { return std::fabs(v.x) + std::fabs(v.y) + std::fabs(v.z); }

  std::span<const Ray> rays_;
  float scale_;
};

// How many rays after the given one the next row passes it: where rays are nearest to it, once they have gone away from it and
// come back. In whole steps; 0 if they do not.
std::size_t first_return(const Distance& distance, std::size_t from, std::size_t longest) {
  float farthest = 0, nearest = std::numeric_limits<float>::infinity();
  std::size_t at = 0;
  for (std::size_t i = kStep; i <= longest; i += kStep) {
    const float d = distance(from, from + i);
    if (nearest == std::numeric_limits<float>::infinity()) {
      if (i < kShortest || !(d < farthest / 4)) {
        farthest = std::max(farthest, d);
        continue;
      }
      longest = std::min(longest, i + i / 2);  // before the row after the next one
    }
    if (d < nearest) nearest = d, at = i;
  }
  return at;
}

// Rays from all over the batch, each of which has some more behind it. At places that no rows are in step with.
class Witnesses {
 public:
  Witnesses(std::size_t count, std::size_t behind) : count_(count - behind) {}

  // Whether most rays say yes.
  template <class Question>
  bool confirm(const Question& question) const {
    std::size_t doubts = 0;
    for (std::size_t w = 0; w < kWitnesses; ++w) doubts += question(place(w)) ? 0 : 1;
    return doubts <= kMostDoubts;
  }
  template <class Value>
  float sum(const Value& value) const {
    float sum = 0;
    for (std::size_t w = 0; w < kWitnesses; ++w) sum += value(place(w));
    return sum;
  }

 private:
  std::size_t place(std::size_t w) const { return w * 2654435761u % count_; }

  std::size_t count_;
};

// Whether rays go away from those before them, as a row's do, and the samples of a pixel do not.
bool go_away(const Distance& distance, std::size_t count) {
  return Witnesses(count, 8 * kStep).confirm([&](std::size_t i) {
    return distance(i, i + kStep) < distance(i, i + 8 * kStep) / 2;
  });
}

// The length near a guess for which rays are nearest to the ones below them, beside those further on; 0 if most are not near.
std::size_t best_length(const Distance& distance, std::size_t count, std::size_t guess) {
  const Witnesses witnesses(count, guess + 2 * kStep);
  std::size_t best = 0;
  float least = std::numeric_limits<float>::infinity();
  for (std::size_t length = guess - kStep; length <= guess + kStep; ++length) {
    // At edges of what is seen, differences are large whatever the length. In this order of arguments, NaN is 1.
    const float sum =
        witnesses.sum([&](std::size_t i) { return std::min(1.0f, distance(i, i + length) / distance(i, i + kStep)); });
    if (sum < least) least = sum, best = length;
  }
  const bool is_near = witnesses.confirm([&](std::size_t i) { return distance(i, i + best) < distance(i, i + kStep) / 2; });
  return is_near ? best : 0;
}

// Where the rays of the first rows jump most: from the end of one to the beginning of the next.
std::size_t find_seam(const Distance& distance, std::size_t length) {
  const auto widest = [](std::size_t begin, std::size_t end, std::size_t step, const auto& jump) {
    std::size_t at = begin;
    float most = 0;
    for (std::size_t i = begin; i < end; i += step)
      if (const float d = jump(i); d > most) most = d, at = i;
    return at;
  };
  const std::size_t coarse = widest(0, length, kStep, [&](std::size_t i) {
    return std::min(distance(i, i + kStep), distance(length + i, length + i + kStep));
  });
  return (widest(coarse, coarse + kStep, 1, [&](std::size_t i) { return distance(i, i + 1); }) + 1) % length;
}

}  // namespace

PixelRows find_rows(std::span<const Ray> rays, float scale) {
  const std::size_t longest = rays.size() / kFewestRows;
  const Distance distance(rays, scale);
  if (longest < kShortest || !go_away(distance, rays.size())) return {};
  for (std::size_t i = 0; i < kGuesses; ++i) {
    const std::size_t guess = first_return(distance, i * rays.size() / 4, longest);
    const std::size_t length = guess == 0 ? 0 : best_length(distance, rays.size(), guess);
    if (length > 0) return {length, find_seam(distance, length)};
  }
  return {};
}

}  // namespace accel
