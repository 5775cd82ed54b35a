#include "libaccel/rays/ray_kind.h"

#include <gtest/gtest.h>

namespace accel {
namespace {

TEST(RayKind, NamesRoundTrip) {
  ASSERT_EQ(ray_kinds().size(), static_cast<std::size_t>(kRayKinds));
  for (const RayKindInfo& kind : ray_kinds()) {
    const auto parsed = parse_ray_kind(kind.name);
    ASSERT_TRUE(parsed.ok()) << kind.name;
    EXPECT_EQ(*parsed, kind.kind);
    EXPECT_EQ(&info(kind.kind), &kind) << "the table is in the order of the enumeration";
  }
}

TEST(RayKind, OnlyImageKindsNeedHits) {
  for (const RayKindInfo& kind : ray_kinds()) EXPECT_TRUE(kind.is_image || !kind.needs_hits) << kind.name;
}

TEST(RayKind, UnknownNamesGetASuggestion) {
  EXPECT_EQ(parse_ray_kind("shadw").message(), "unknown ray kind 'shadw'; did you mean 'shadow'?");
  EXPECT_FALSE(parse_ray_kind("").ok());
}

}  // namespace
}  // namespace accel
