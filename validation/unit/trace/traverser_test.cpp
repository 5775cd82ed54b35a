#include "libaccel/trace/traverser.h"

#include <gtest/gtest.h>

#include <cmath>
#include <type_traits>

#include "libaccel/core/float_bounds.h"
#include "validation/unit/special_floats.h"

namespace accel {
namespace {

Hit start(float t_max) {
  Hit hit;
  begin_hit({.org = {}, .dir = {1, 0, 0}, .t_max = t_max}, hit);
  return hit;
}

TEST(AcceptHit, BothEndsOfTheIntervalBelongToIt) {
  for (const float t : {1.0f, 2.0f, 3.0f}) {
    Hit hit = start(3);
    EXPECT_TRUE(accept_hit({.t = t, .prim_id = 5}, 1.0f, hit)) << t;
    EXPECT_EQ(hit.t, t);
  }
  for (const float t : {next_down(1.0f), next_up(3.0f)}) {
    Hit hit = start(3);
    EXPECT_FALSE(accept_hit({.t = t, .prim_id = 5}, 1.0f, hit)) << t;
    EXPECT_FALSE(hit.valid());
  }
}

TEST(AcceptHit, NearerWinsAndTheLowestNumberAmongEquals) {
  Hit hit = start(kInfinity);
  EXPECT_TRUE(accept_hit({.t = 2, .prim_id = 7}, 0, hit));
  EXPECT_FALSE(accept_hit({.t = 2, .prim_id = 8}, 0, hit));
  EXPECT_FALSE(accept_hit({.t = 2, .prim_id = 7}, 0, hit));
  EXPECT_TRUE(accept_hit({.t = 2, .prim_id = 3}, 0, hit));
  EXPECT_FALSE(accept_hit({.t = 2.5f, .prim_id = 0}, 0, hit));
  EXPECT_TRUE(accept_hit({.t = 1, .prim_id = 9}, 0, hit));
  EXPECT_EQ(hit.prim_id, 9u);
}

TEST(AcceptHit, RefusesNaNAndInfinity) {
  Hit hit = start(kInfinity);
  EXPECT_FALSE(accept_hit({.t = std::nanf(""), .prim_id = 0}, 0, hit));
  EXPECT_FALSE(accept_hit({.t = kInfinity, .prim_id = 0}, 0, hit));
  EXPECT_FALSE(accept_hit({.t = -kInfinity, .prim_id = 0}, 0, hit));
  EXPECT_TRUE(accept_hit({.t = std::numeric_limits<float>::max(), .prim_id = 0}, 0, hit));
}

TEST(BeginHit, IntervalsStartAtTheOriginAtTheEarliest) {
  EXPECT_EQ(first_t({.org = {}, .t_min = -3, .dir = {1, 0, 0}}), 0.0f);
  EXPECT_EQ(first_t({.org = {}, .t_min = 3, .dir = {1, 0, 0}}), 3.0f);
}

TEST(FinishHit, AMissForgetsTheInterval) {
  Hit hit = start(3);
  finish_hit(hit);
  EXPECT_FALSE(hit.valid());
  EXPECT_EQ(hit.t, kInfinity);

  Hit found{.t = 2, .u = 0.25f, .v = 0.5f, .prim_id = 1};
  finish_hit(found);
  EXPECT_EQ(found.t, 2.0f);
}

TEST(NullObserver, HoldsNothing) { EXPECT_TRUE(std::is_empty_v<NullObserver>); }

}  // namespace
}  // namespace accel
