// A list of triangles and rays that hurt, for tests of executors.
#pragma once

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "libaccel/build/triangle_list.h"
#include "validation/stress/stress_rays.h"
#include "validation/stress/stress_scenes.h"

namespace accel {

class ListAndRays : public testing::Test {
 protected:
  ListAndRays()
      : mesh_(validation::mesh_of(validation::random_triangles(50, 0.5f, 1))), rays_(validation::stress_rays(mesh_, 10'000)) {
    auto built = ListBuilder::build(mesh_, {});
    EXPECT_TRUE(built) << built.message();
    list_ = std::move(built->structure);
  }

  TriangleMesh mesh_;
  std::vector<Ray> rays_;
  TriangleList list_;
};

}  // namespace accel
