#include "validation/compare/repro.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "libaccel/io/load_mesh.h"
#include "libaccel/io/npy.h"
#include "validation/unit/compare/test_scenes.h"
#include "validation/unit/io/io_test_support.h"

namespace accel::validation {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

class Repro : public FileTest {};

TEST_F(Repro, HoldsEverythingThatIsNeeded) {
  const TriangleMesh mesh = test::transformed(test::square(), 0.1f, {0.3f, 0.3f, 0.3f});
  const Judge judge(mesh);
  const std::vector<Ray> rays{{{0.32f, 0.31f, 1}, 0, {0, 0, -1}}, {{0.31f, 0.32f, 1}, 0, {0, 0, -1}, 8}};
  const std::vector<Hit> right = test::brute_force<Watertight>(mesh, rays), ours{right[0], Hit{}};
  const Result<CheckResult> result = compare(judge, rays, ours, right);
  ASSERT_TRUE(result.ok());
  ASSERT_EQ(result->failures(), 1);

  const std::vector<ReproCase> cases = repro_cases(*result, rays, ours, std::span<const Hit>(right));
  ASSERT_EQ(cases.size(), 1);
  EXPECT_EQ(cases[0].ray_number, 1);
  EXPECT_EQ(cases[0].verdict, Verdict::miss);

  const auto path = write_repro(
      folder() / "found", judge, cases,
      {"accel-trace demo.ply --seed 7", "my demo.ply", "bvh/stack", Query::closest, {"--seed", "7", "--test", "woop"}});
  ASSERT_TRUE(path.ok()) << path.message();
  const std::string text = contents(*path);
  EXPECT_THAT(text, HasSubstr("found by  accel-trace demo.ply --seed 7\n"));
  EXPECT_THAT(text,
              HasSubstr("again     accel-trace 'my demo.ply' --seed 7 --test woop --method bvh/stack --check exact --rays " +
                        (folder() / "found-rays.npy").string() + "\n"));
  EXPECT_THAT(text, HasSubstr("ray 1: miss\n"));
  EXPECT_THAT(text, HasSubstr("hit at exactly this t: 1\n"));
  EXPECT_THAT(text, HasSubstr("triangle 1\n"));
  EXPECT_THAT(text, Not(HasSubstr("triangle 0\n")));

  const auto again = read_rays_npy(folder() / "found-rays.npy");
  ASSERT_TRUE(again.ok());
  ASSERT_EQ(again->size(), 1);
  EXPECT_TRUE((*again)[0].org == rays[1].org && (*again)[0].dir == rays[1].dir);
  EXPECT_EQ((*again)[0].t_max, 8);

  const auto triangles = load_mesh(folder() / "found.obj");
  ASSERT_TRUE(triangles.ok()) << triangles.message();
  ASSERT_EQ(triangles->size(), 1);
  const Triangle a = triangles->triangle(0), b = mesh.triangle(1);
  EXPECT_TRUE(a.v0 == b.v0 && a.v1 == b.v1 && a.v2 == b.v2) << "every bit";
}

TEST_F(Repro, AnyHitAndUnwritableFolders) {
  const TriangleMesh mesh = test::square();
  const Judge judge(mesh);
  const std::vector<Ray> rays{{{0.75f, 0.25f, 1}, 0, {0, 0, -1}}};
  const std::vector<std::uint8_t> ours{0}, witness{1};
  const Result<CheckResult> result = compare_any(judge, rays, ours, witness);
  ASSERT_TRUE(result.ok());
  const std::vector<ReproCase> cases = repro_cases(*result, rays, ours, std::span<const std::uint8_t>(witness));
  const auto path = write_repro(folder() / "any", judge, cases, {"accel-trace", "demo.ply", "bvh/stack", Query::any, {}});
  ASSERT_TRUE(path.ok()) << path.message();
  const std::string text = contents(*path);
  EXPECT_THAT(text, HasSubstr("again     accel-trace demo.ply --query any --method bvh/stack "));
  EXPECT_THAT(text, HasSubstr("query     any hit\n"));
  EXPECT_THAT(text, HasSubstr("ours     free\n"));
  EXPECT_THAT(text, HasSubstr("witness  occluded\n"));

  EXPECT_FALSE(write_repro(folder() / "no" / "such" / "folder", judge, cases, {}).ok());
}

}  // namespace
}  // namespace accel::validation
