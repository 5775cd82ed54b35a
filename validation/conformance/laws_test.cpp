// The laws of validation/stress/laws.h, for every method and triangle test.
#include "validation/stress/laws.h"

#include "validation/conformance/method_test.h"
#include "validation/stress/stress_rays.h"

namespace accel::validation {
namespace {

class Laws : public MethodTest {
 protected:
  // Of scenes that hurt. No law is broken, and the share of rays whose answers differ, which exact arithmetic excuses, is
  // small. Moeller and Trumbore's test has no bound on its errors, so its hits may lie far outside of their boxes, and nobody
  // is asked to excuse them: ten times as many may differ, and slivers, where hits of this test are mostly errors, are not
  // compared.
  static void expect(Law law, std::size_t rays_of_each, std::uint64_t seed, double share) {
    for (const StressScene& scene : stress_scenes(seed)) {
      if (!has_range_for(law, scene)) continue;
      const std::vector<Ray> rays = stress_rays(scene.mesh, rays_of_each, seed);
      const Result<LawResult> result = check_law(law, scene, rays, {GetParam().method, GetParam().test});
      ASSERT_TRUE(result) << result.message();
      EXPECT_TRUE(scene.mesh.size() == 0 || result->rays > rays.size() / 20) << scene.name << ": the rays test nothing";
      if (!is_watertight() && scene.name == "slivers") continue;
      EXPECT_EQ(result->broken, 0u) << result->what;
      const double most = share * static_cast<double>(result->rays) * (is_watertight() ? 1 : 10);
      EXPECT_LE(static_cast<double>(result->different), share > 0 ? 1 + most : 0) << scene.name;
    }
  }
};

// Laws that ask more than Moeller and Trumbore's test can promise.
class WatertightLaws : public Laws {};

TEST_P(Laws, Scale) { expect(Law::scale, 400, 1, 0); }
TEST_P(Laws, Order) { expect(Law::order, 1000, 22, 0.001); }
TEST_P(Laws, Union) { expect(Law::unions, 500, 24, 0.001); }
TEST_P(Laws, AnyHit) { expect(Law::any, 2000, 3, 0); }
TEST_P(Laws, Intervals) { expect(Law::intervals, 1500, 11, 0.001); }
TEST_P(WatertightLaws, Axes) { expect(Law::axes, 300, 23, 0.01); }
// Many of these rays start on surfaces, which are hit or not according to the end from which t is counted.
TEST_P(WatertightLaws, Reversed) { expect(Law::reversed, 150, 25, 0.6); }

// A check that nothing can break would test nothing: triangles of 2^-40, scaled by 2^-40, leave the range of the test.
TEST(LawsThemselves, CanBeBroken) {
  for (const StressScene& scene : stress_scenes()) {
    if (scene.name != "nested") continue;
    const Result<LawResult> result =
        check_law(Law::scale, scene, stress_rays(scene.mesh, 400, 21), {"bvh/stack", "watertight"});
    ASSERT_TRUE(result) << result.message();
    EXPECT_GT(result->broken, 0u);
    EXPECT_FALSE(result->cases.empty());
  }
}

}  // namespace

ACCEL_FOR_EVERY_METHOD(Laws);
ACCEL_FOR_EVERY_PROMISE(WatertightLaws);

}  // namespace accel::validation
