// What tests of SIMD traversal have in common: all targets that the machine has, batches of all sizes, hits bit for bit.
#pragma once

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <algorithm>
#include <bit>
#include <iterator>
#include <set>
#include <span>
#include <string>

#include "libaccel/trace/bvh8_simd.h"

namespace accel::test {

template <class Body>
void on_every_target(const Body& body) {
  std::set<std::string> ran;
  for (const auto target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    EXPECT_STREQ(bvh8_simd_target(), hwy::TargetName(target));
    ran.insert(bvh8_simd_target());
    body();
  }
  hwy::SetSupportedTargetsForTest(0);
  EXPECT_FALSE(ran.empty());
}

inline bool same(const Hit& a, const Hit& b) {
  return std::bit_cast<std::uint32_t>(a.t) == std::bit_cast<std::uint32_t>(b.t) && a.prim_id == b.prim_id &&
         std::bit_cast<std::uint32_t>(a.u) == std::bit_cast<std::uint32_t>(b.u) &&
         std::bit_cast<std::uint32_t>(a.v) == std::bit_cast<std::uint32_t>(b.v);
}

// In batches of few rays, which are traced one after the other, of some more than go by turns at a time, and of many.
template <class View, class Answer>
void trace_in_batches(const SimdFunctions<View>& functions, const View& view, std::span<const Ray> rays,
                      std::span<Answer> answers) {
  constexpr std::size_t kSizes[] = {1, kFewestInTurns - 1, kFewestInTurns, 23, 24, 25, 26, 49, 0, 500};
  std::size_t begin = 0;
  for (std::size_t i = 0; begin < rays.size(); ++i) {
    const std::size_t size = std::min(i < std::size(kSizes) ? kSizes[i] : rays.size(), rays.size() - begin);
    functions.trace(view, rays.data() + begin, size, answers.data() + begin);
    begin += size;
  }
}

}  // namespace accel::test
