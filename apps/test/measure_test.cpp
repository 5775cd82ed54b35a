#include "apps/common/measure.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace accel::apps {
namespace {

// An engine that takes `seconds` for each call, hits everything at t = ray number and writes down when it was called.
Engine fake_engine(const std::string& name, double seconds, std::vector<std::string>& calls) {
  Engine engine;
  engine.name = name;
  engine.closest = [=, &calls](std::span<const Ray> rays, std::span<Hit> hits) -> Result<double> {
    calls.push_back(name);
    for (std::size_t i = 0; i < rays.size(); ++i) hits[i] = {rays[i].org.x, 0, 0, 7};
    return seconds;
  };
  engine.occluded = [=](std::span<const Ray>, std::span<std::uint8_t> occluded) -> Result<double> {
    std::fill(occluded.begin(), occluded.end(), std::uint8_t{1});
    return seconds;
  };
  return engine;
}

std::vector<Ray> numbered_rays(std::size_t count) {
  std::vector<Ray> rays(count);
  for (std::size_t i = 0; i < count; ++i) rays[i].org.x = static_cast<float>(i);
  return rays;
}

TEST(Measure, EnginesTakeTurnsAndEachRepetitionStartsWithAnother) {
  std::vector<std::string> calls;
  std::vector<Engine> engines = {fake_engine("a", 1, calls), fake_engine("b", 2, calls)};
  ProgressBar bar(When::never, true);
  const auto measured = measure(engines, numbered_rays(10), Query::closest, 2, bar);
  ASSERT_TRUE(measured);
  EXPECT_EQ(calls, (std::vector<std::string>{"a", "b", "b", "a", "a", "b"}));
  EXPECT_EQ((*measured)[0].passes.size(), 2u);
  EXPECT_DOUBLE_EQ((*measured)[0].speed.median, 10e-6);
  EXPECT_DOUBLE_EQ((*measured)[1].speed.most, 5e-6);
}

TEST(Measure, AnswersArriveWholeWhenBatchesAreCut) {
  std::vector<std::string> calls;
  std::vector<Engine> engines = {fake_engine("slow", 1, calls)};  // too slow for its calls to grow
  const std::size_t count = 3 * Engine::kFirstCall + 1;
  ProgressBar bar(When::never, true);
  const auto measured = measure(engines, numbered_rays(count), Query::closest, 0, bar);
  ASSERT_TRUE(measured);
  EXPECT_EQ(calls.size(), 4u);
  const Buffer<Hit>& hits = measured->front().answers.hits;
  ASSERT_EQ(hits.size(), count);
  for (std::size_t i = 0; i < count; ++i) ASSERT_EQ(hits[i].t, static_cast<float>(i));
  EXPECT_TRUE(measured->front().answers.occluded.empty());
}

TEST(Measure, CallsOfFastEnginesGrow) {
  std::vector<std::string> calls;
  std::vector<Engine> engines = {fake_engine("fast", 1e-6, calls)};
  ProgressBar bar(When::never, true);
  ASSERT_TRUE(measure(engines, numbered_rays(21 * Engine::kFirstCall), Query::closest, 1, bar));
  EXPECT_EQ(calls.size(), 3u + 1u);  // 1 + 4 + 16 while learning, then one call
}

TEST(Measure, ErrorsOfEnginesAreReported) {
  std::vector<Engine> engines(1);
  engines[0].occluded = [](std::span<const Ray>, std::span<std::uint8_t>) -> Result<double> { return Error{"broken"}; };
  ProgressBar bar(When::never, true);
  const auto measured = measure(engines, numbered_rays(1), Query::any, 1, bar);
  ASSERT_FALSE(measured);
  EXPECT_EQ(measured.failure().message, "broken");
  EXPECT_EQ(measured.failure().status, ExitStatus::error);
}

TEST(Measure, InterruptionHasItsOwnStatus) {
  EXPECT_EQ(Failure(Error{"interrupted"}).status, ExitStatus::interrupted);
  EXPECT_EQ(Failure(Error{"interrupted.ply does not exist"}).status, ExitStatus::error);
}

TEST(Measure, NoRaysNeedNoTime) {
  std::vector<std::string> calls;
  std::vector<Engine> engines = {fake_engine("a", 1, calls)};
  ProgressBar bar(When::never, true);
  const auto measured = measure(engines, {}, Query::any, 1, bar);
  ASSERT_TRUE(measured);
  EXPECT_TRUE(calls.empty());
  EXPECT_EQ((*measured)[0].speed.median, 0);
}

}  // namespace
}  // namespace accel::apps
