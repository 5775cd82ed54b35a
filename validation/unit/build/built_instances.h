// Instances as a builder of them makes them, for the tests of what concerns the result.
#pragma once

#include <gtest/gtest.h>

#include <utility>

#include "libaccel/build/instances.h"
#include "libaccel/build/wide_instances.h"

namespace accel::test {

template <class Builder = InstanceBuilder>
typename Builder::Structure built(const InstancedMeshes& scene, const BuildOptions& options = {}) {
  auto result = Builder::build(scene, options);
  EXPECT_TRUE(result) << result.message();
  return std::move(result->structure);
}

}  // namespace accel::test
