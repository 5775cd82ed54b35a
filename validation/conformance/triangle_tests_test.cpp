// Every triangle test with every method: hits as brute force's with the same test, errors where a method cannot have it.
#include "validation/conformance/method_test.h"
#include "validation/stress/stress_rays.h"
#include "validation/stress/stress_scenes.h"

namespace accel::validation {
namespace {

class OtherTests : public MethodTest {
 protected:
  static std::vector<Hit> hits_with(const AnyAccel& accel, const std::vector<Ray>& rays, const std::string& test, int threads) {
    std::vector<Hit> hits(rays.size());
    const Status status = accel.closest(rays, hits, {.threads = threads, .test = test});
    EXPECT_TRUE(status) << status.message();
    return hits;
  }
};

// Tests without a bound may see a triangle from a leaf that the ray does not reach: one ray in a hundred.
TEST_P(OtherTests, HitsAsBruteForce) {
  const TriangleMesh mesh = mesh_of(random_triangles(400, 0.3f, 95));
  const std::vector<Ray> rays = stress_rays(mesh, 2000, 95);
  const AnyAccel accel = build(mesh), brute = build_brute_force(mesh);
  std::size_t accepted = 0;
  for (const std::string& test : triangle_tests()) {
    if (!accel.accepts(test)) continue;
    ++accepted;
    const std::vector<Hit> ours = hits_with(accel, rays, test, 1), expected = hits_with(brute, rays, test, 1);
    std::size_t different = 0, hits = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) different += !(ours[i] == expected[i]), hits += expected[i].valid();
    EXPECT_LE(different, rays.size() / 100) << test;
    EXPECT_GT(hits, rays.size() / 3) << test;
    EXPECT_TRUE(hits_with(accel, rays, test, 3) == ours) << test << " on three threads";

    std::vector<std::uint8_t> any(rays.size());
    ASSERT_TRUE(accel.occluded(rays, any, {.threads = 1, .test = test}));
    for (std::size_t i = 0; i < rays.size(); ++i) EXPECT_EQ(any[i] != 0, ours[i].valid()) << test << ", ray " << i;
    const auto counters = accel.count(rays, Query::closest, {}, {.threads = 1, .test = test});
    ASSERT_TRUE(counters) << counters.message();
    EXPECT_GT(counters->triangle_tests, 0u);
  }
  EXPECT_GE(accepted, triangle_tests().size() - 1);
}

// Methods that are known to lose hits lose few.
TEST(OtherMethods, LoseFewHits) {
  const TriangleMesh mesh = mesh_of(random_triangles(400, 0.3f, 97));
  const std::vector<Ray> rays = stress_rays(mesh, 4000, 97);
  const auto hits_of = [&](const std::string& method) {
    const Result<AnyAccel> accel = AnyAccel::build(mesh, method);
    EXPECT_TRUE(accel) << accel.message();
    std::vector<Hit> hits(rays.size());
    EXPECT_TRUE(accel->closest(rays, hits));
    return hits;
  };
  const std::vector<Hit> expected = hits_of("brute/loop");
  std::size_t methods_of_this_kind = 0;
  for (const MethodInfo& method : methods()) {
    if (method.robust) continue;
    ++methods_of_this_kind;
    const std::vector<Hit> hits = hits_of(method.name);
    std::size_t different = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) different += !(hits[i] == expected[i]);
    EXPECT_LE(different, rays.size() / 20) << method.name;
  }
  EXPECT_EQ(methods_of_this_kind, 2u);
}

// What cannot be traced is an error with a reason, for every kind of query.
TEST_P(OtherTests, ErrorsSayWhatThereIs) {
  const AnyAccel accel = build(mesh_of(random_triangles(50, 0.3f, 96)));
  const std::vector<Ray> rays{{.org = {0, 0, -5}, .dir = {0, 0, 1}}};
  std::vector<Hit> hits(1);
  std::vector<std::uint32_t> counts(1);
  const Status unknown = accel.closest(rays, hits, {.test = "wooop"});
  ASSERT_FALSE(unknown);
  EXPECT_NE(unknown.message().find("did you mean 'woop'"), std::string::npos) << unknown.message();
  EXPECT_FALSE(accel.is_tuned_for("wooop"));
  for (const std::string& test : triangle_tests()) {
    const bool modelled = std::count(modelled_tests().begin(), modelled_tests().end(), test) > 0;
    const TraceOptions options{.threads = 1, .test = test};
    EXPECT_EQ(accel.closest(rays, hits, options).ok(), accel.accepts(test).ok()) << test;
    EXPECT_EQ(accel.k_nearest(rays, 1, hits, counts, options).ok(), modelled) << test;
    EXPECT_EQ(accel.profile_simt(rays, Query::closest, {}, {}, options).ok(), modelled) << test;
    EXPECT_EQ(accel.trace_multipass(rays, Query::closest, {}, {}, options).ok(), modelled) << test;
    if (const Status s = accel.accepts(test); !s) {
      EXPECT_NE(s.message().find("have no room"), std::string::npos) << s.message();
    }
  }
}

}  // namespace

ACCEL_FOR_EVERY_PROMISE(OtherTests);

}  // namespace accel::validation
