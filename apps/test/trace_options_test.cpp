#include "apps/common/trace_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace accel::apps {
namespace {

using testing::HasSubstr;

Outcome<TraceSettings> parse(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "accel-trace");
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  return parse_trace_options(static_cast<int>(arguments.size()), argv.data());
}

// A usage error of one line that says `words`. validation/cli/cli_test.sh has what programs make of that.
void expect_refused(const std::vector<std::string>& arguments, const std::string& words) {
  SCOPED_TRACE(testing::PrintToString(arguments));
  const Outcome<TraceSettings> settings = parse(arguments);
  ASSERT_FALSE(settings);
  EXPECT_EQ(settings.failure().status, ExitStatus::usage);
  EXPECT_THAT(settings.failure().message, HasSubstr(words));
  EXPECT_EQ(std::count(settings.failure().message.begin(), settings.failure().message.end(), '\n'), 0);
}

TEST(TraceOptions, GoodNumbersAreTaken) {
  const auto settings =
      parse({"builtin:cornell", "--rays", "primary,edge", "--width", "7", "--height", "5", "--spp", "3", "--count", "11"});
  ASSERT_TRUE(settings) << settings.failure().message;
  EXPECT_EQ(settings->width, 7u);
  EXPECT_EQ(settings->height, 5u);
  EXPECT_EQ(settings->spp, 3u);
  EXPECT_EQ(settings->count, 11u);
}

TEST(TraceOptions, ModesOfEmbreeAreLookedUp) {
  const auto none = parse({"builtin:cornell"}), some = parse({"builtin:cornell", "--embree", "robust,stream"});
  ASSERT_TRUE(none && some);
  EXPECT_TRUE(none->embree.empty());
  EXPECT_EQ(some->embree, (std::vector<std::string>{"robust", "stream"}));
  expect_refused({"--embree", "robst"}, "did you mean 'robust'?");
  expect_refused({"--embree", "fast,"}, "--embree");
}

TEST(TraceOptions, QueriesAreLookedUp) {
  const auto none = parse({"builtin:cornell"}), any = parse({"--query", "any"}), closest = parse({"--query", "closest"});
  ASSERT_TRUE(none && any && closest);
  EXPECT_EQ(none->query, std::nullopt);
  EXPECT_EQ(any->query, Query::any);
  EXPECT_EQ(closest->query, Query::closest);
  expect_refused({"--query", "closst"}, "did you mean 'closest'?");
}

TEST(TraceOptions, OrdersOfPixelsAreLookedUp) {
  const auto none = parse({"builtin:cornell"}), curve = parse({"--pixel-order", "z-curve"});
  ASSERT_TRUE(none && curve);
  EXPECT_EQ(none->pixel_order, PixelOrder::rows);
  EXPECT_EQ(curve->pixel_order, PixelOrder::z_curve);
  expect_refused({"--pixel-order", "zcurve"}, "did you mean 'z-curve'?");
}

TEST(TraceOptions, BadNumbersNameTheFlag) {
  for (const std::string flag : {"--width", "--height", "--spp", "--count", "--judge-limit"})
    for (const std::string bad : {"0", "-1", "1.5", "abc", "99999999999999999999", ""})
      expect_refused({"builtin:cornell", flag, bad}, flag);
}

TEST(TraceOptions, NumbersHaveTheirRanges) {
  expect_refused({"--seed", "-1"}, "--seed");
  expect_refused({"--threads", "-2"}, "--threads");
  expect_refused({"--threads", "4096"}, "from 0 to 1,024");
  expect_refused({"--repeat", "0"}, "--repeat");
  expect_refused({"--max-leaf-size", "0"}, "--max-leaf-size");
  expect_refused({"--bins", "65"}, "--bins");
  expect_refused({"--max-duplication", "16"}, "--max-duplication");
  expect_refused({"--reinsertion-rounds", "1001"}, "from 0 to 1,000");
  expect_refused({"--reinsertion-seconds", "-1"}, "--reinsertion-seconds");
  expect_refused({"--reinsertion-seconds", "nan"}, "--reinsertion-seconds");
  expect_refused({"--traversal-cost", "nan"}, "--traversal-cost");
  expect_refused({"--traversal-cost", "inf"}, "--traversal-cost");
  expect_refused({"--width", "65536", "--height", "65536", "--spp", "1000"}, "--spp");
}

TEST(TraceOptions, OptionsWithoutEffectAreRefused) {
  expect_refused({"builtin:cornell", "--schedule", "if-if"}, "is about warps; add --profile simt");
  expect_refused({"builtin:cornell", "--profile", "simt", "--schedule", "if-if,drain"},
                 "is about passes; add --profile multipass");
  expect_refused({"builtin:cornell", "--profile", "simt", "--schedule", "if-if,persistent"}, "give one of them");
  expect_refused({"builtin:cornell", "--profile", "simt", "--batch", "9"}, "--batch: is about passes");
  expect_refused({"builtin:cornell", "--compact"}, "--compact: is about passes");
  expect_refused({"builtin:cornell", "--heatmap-of", "leaves"}, "--heatmap-of: is about heat maps");
  expect_refused({"builtin:cornell", "--count", "9"}, "--count: is about rays that have no pixels");
  expect_refused({"builtin:cornell", "--rays", "mine.npy,random", "--spp", "2"}, "--spp: is about rays that have pixels");
  expect_refused({"builtin:cornell", "--rays", "edge", "--pixel-order", "rows"},
                 "--pixel-order: is about rays that have pixels");
  EXPECT_TRUE(parse({"builtin:cornell", "--profile", "multipass", "--schedule", "drain", "--batch", "9", "--compact"}));
  EXPECT_TRUE(parse({"builtin:cornell", "--report", "-", "--heatmap-of", "leaves"}));
  EXPECT_TRUE(parse({"--count", "9", "--spp", "2"})) << "the demo has both kinds of rays";
  EXPECT_TRUE(parse({"builtin:cornell", "--sweep", "--rays", "primary", "--count", "9"})) << "edge rays are added";
}

TEST(TraceOptions, OutputsAreDifferentFiles) {
  expect_refused({"--rays-out", "x.npy", "--hits-out", "./x.npy"}, "--rays-out, --hits-out: only one of them");
  expect_refused({"--json", "same.html", "--report", "same.html"}, "--json, --report: only one of them");
  expect_refused({"--json", "-", "--report", "-"}, "standard output");
  EXPECT_TRUE(parse({"--rays-out", "x.npy", "--hits-out", "y.npy", "--json", "-"}));
}

// In either order.
TEST(TraceOptions, SecondsOfReinsertionAloneAskForAllRounds) {
  const auto none = parse({"builtin:cornell"}), no_limit = parse({"--reinsertion-seconds", "0"}),
             alone = parse({"--reinsertion-seconds", "0.5"}),
             after = parse({"--reinsertion-rounds", "2", "--reinsertion-seconds", "0.5"}),
             before = parse({"--reinsertion-seconds", "0.5", "--reinsertion-rounds", "2"});
  ASSERT_TRUE(none && no_limit && alone && after && before);
  EXPECT_EQ(none->build.reinsertion_rounds, BuildOptions{}.reinsertion_rounds);
  EXPECT_EQ(no_limit->build.reinsertion_rounds, BuildOptions{}.reinsertion_rounds);
  EXPECT_EQ(alone->build.reinsertion_rounds, kMaxReinsertionRounds);
  EXPECT_EQ(alone->build.reinsertion_seconds, 0.5f);
  for (const auto* both : {&after, &before}) {
    EXPECT_EQ((*both)->build.reinsertion_rounds, 2);
    EXPECT_EQ((*both)->build.reinsertion_seconds, 0.5f);
  }
}

}  // namespace
}  // namespace accel::apps
