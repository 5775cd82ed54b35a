// Instances as InstanceBuilder builds them, for the tests of what concerns the result.
#pragma once

#include <gtest/gtest.h>

#include <utility>

#include "libaccel/build/instances.h"

namespace accel::test {

inline TwoLevelBvh built(const InstancedMeshes& scene, const BuildOptions& options = {}) {
  auto result = InstanceBuilder::build(scene, options);
  EXPECT_TRUE(result) << result.message();
  return std::move(result->structure);
}

}  // namespace accel::test
