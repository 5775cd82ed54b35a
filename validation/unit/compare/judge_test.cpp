#include "validation/compare/judge.h"

#include <gtest/gtest.h>

#include "libaccel/core/float_bounds.h"
#include "validation/unit/compare/test_scenes.h"
#include "validation/unit/special_floats.h"

namespace accel::validation {
namespace {

using test::make_mesh;

const Hit kMiss;

Ray ray_to(Vec3 org, Vec3 dir, float t_min = 0, float t_max = kInfinity) { return {org, t_min, dir, t_max}; }
Hit hit_at(float t, std::uint32_t prim_id) { return {t, 0, 0, prim_id}; }

Verdict judge(const Judge& judge, const Ray& ray, const Hit& hit) { return judge.judge(ray, hit, judge.oracle().closest(ray)); }
Verdict judge_any(const Judge& judge, const Ray& ray, bool occluded) {
  return judge.judge_any(ray, occluded, judge.oracle().any(ray));
}

std::size_t count_failures(const Judge& referee, const std::vector<Ray>& rays, const std::vector<Hit>& hits) {
  std::size_t failures = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) failures += is_failure(judge(referee, rays[i], hits[i]));
  return failures;
}

TEST(Judge, PlainHitsAndMisses) {
  const Judge referee(test::square());
  const Ray hits = ray_to({0.75f, 0.25f, 3}, {0, 0, -2}), misses = ray_to({1.5f, 0.25f, 3}, {0, 0, -2});
  EXPECT_EQ(judge(referee, hits, hit_at(1.5f, 0)), Verdict::right);
  EXPECT_EQ(judge(referee, hits, hit_at(next_up(1.5f), 0)), Verdict::right);
  EXPECT_EQ(judge(referee, hits, hit_at(1.5001f, 0)), Verdict::far);
  EXPECT_EQ(judge(referee, hits, hit_at(1.4999f, 0)), Verdict::false_hit);
  EXPECT_EQ(judge(referee, hits, hit_at(std::numeric_limits<float>::quiet_NaN(), 0)), Verdict::false_hit);
  EXPECT_EQ(judge(referee, hits, hit_at(1.5f, 1)), Verdict::false_hit);
  EXPECT_EQ(judge(referee, hits, hit_at(1.5f, 99)), Verdict::false_hit);
  EXPECT_EQ(judge(referee, hits, kMiss), Verdict::miss);
  EXPECT_EQ(judge(referee, misses, kMiss), Verdict::right);
  EXPECT_EQ(judge(referee, misses, hit_at(1.5f, 0)), Verdict::false_hit);
  EXPECT_EQ(judge(referee, ray_to({0.75f, 0.25f, 3}, {0, 0, 0}), kMiss), Verdict::right);
  EXPECT_EQ(judge(referee, ray_to({0.75f, 0.25f, 3}, {0, 0, 0}), hit_at(1.5f, 0)), Verdict::false_hit);
}

TEST(Judge, ASharedEdgeIsNoExcuseForAMiss) {
  const Judge referee(test::square());
  for (const float x : {0.25f, 0.3f, 0.9f}) {
    for (const float offset : {0.0f, 0x1p-26f, -0x1p-26f}) {
      const Ray ray = ray_to({x, x + offset, 1}, {0, 0, -1});
      EXPECT_EQ(judge(referee, ray, kMiss), Verdict::miss) << x << " " << offset;
      EXPECT_EQ(judge_any(referee, ray, false), Verdict::miss);
      for (const std::uint32_t prim : {0u, 1u}) {
        const bool exact = referee.oracle().closest(ray).contains(prim);
        EXPECT_EQ(judge(referee, ray, hit_at(1, prim)), exact ? Verdict::right : Verdict::neighbour);
      }
    }
  }
}

TEST(Judge, ABoundaryEdgeExcusesBoth) {
  const Judge referee(test::square());
  const Ray on = ray_to({0.3f, 1, 1}, {0, 0, -1}), beside = ray_to({0.3f, 0, 1}, {0, next_up(1), -1});
  EXPECT_EQ(judge(referee, on, kMiss), Verdict::edge);
  EXPECT_EQ(judge(referee, on, hit_at(1, 1)), Verdict::right);
  EXPECT_EQ(judge(referee, beside, kMiss), Verdict::right);
  EXPECT_EQ(judge(referee, beside, hit_at(1, 1)), Verdict::edge);
  EXPECT_EQ(judge_any(referee, on, false), Verdict::edge);
  EXPECT_EQ(judge_any(referee, beside, true), Verdict::edge);

  // The bound is relative to the distance from the origin: straight above the edge, one unit in the last place is no rounding.
  const Ray above = ray_to({0.3f, next_up(1), 1}, {0, 0, -1});
  EXPECT_EQ(judge(referee, above, hit_at(1, 1)), Verdict::false_hit);

  // Nor are a thousand anywhere.
  const Ray clear = ray_to({0.3f, 1.0001f, 1}, {0, 0, -1}), well_inside = ray_to({0.3f, 0.9999f, 1}, {0, 0, -1});
  EXPECT_EQ(judge(referee, clear, hit_at(1, 1)), Verdict::false_hit);
  EXPECT_EQ(judge_any(referee, clear, true), Verdict::false_hit);
  EXPECT_EQ(judge(referee, well_inside, kMiss), Verdict::miss);
  EXPECT_EQ(judge_any(referee, well_inside, false), Verdict::miss);
}

// From inside a closed mesh nothing may be missed, whatever the ray is aimed at.
TEST(Judge, NoMissIsExcusedInsideAClosedMesh) {
  for (const TriangleMesh& shared : {test::tetrahedron(), test::transformed(test::cube(), 2, {-1, -1, -1}), test::sphere(3)}) {
    for (const float offset : {0.0f, 1.0f, 100.0f}) {
      const Vec3 centre{offset, -offset, offset};
      const TriangleMesh mesh = test::transformed(shared, 1, centre);
      const Judge referee(mesh), without_sharing(test::unshared(mesh));
      for (const Ray& ray : test::edge_rays(mesh, centre, 0.1f, 300, 11)) {
        EXPECT_EQ(judge(referee, ray, kMiss), Verdict::miss);
        EXPECT_EQ(judge(without_sharing, ray, kMiss), Verdict::miss);
        EXPECT_EQ(judge_any(referee, ray, false), Verdict::miss);
      }
    }
  }
}

// From outside, the far side of a closed mesh is no substitute for the near one, unless the ray grazes the silhouette.
TEST(Judge, TheFarSideIsFar) {
  const TriangleMesh mesh = test::sphere(3);
  const Judge referee(mesh);
  const std::vector<Ray> rays = test::edge_rays(mesh, {5, 4, 3}, 0.1f, 1000, 12);
  std::size_t far = 0, edge = 0, right = 0;
  for (const Ray& ray : rays) {
    const ExactHit near = referee.oracle().closest(ray);
    if (!near.valid()) continue;
    Ray rest = ray;
    rest.t_min = static_cast<float>(near.t + 1e-3);
    const ExactHit behind = referee.oracle().closest(rest);
    if (!behind.valid()) continue;
    const Verdict verdict = judge(referee, ray, hit_at(static_cast<float>(behind.t), behind.prims[0]));
    far += verdict == Verdict::far, edge += verdict == Verdict::edge, right += verdict == Verdict::right;
  }
  EXPECT_EQ(right, 0);
  EXPECT_GT(far, 500);
  EXPECT_LT(edge, 50);
}

TEST(Judge, TheSilhouetteIsAnEdge) {
  // The cube's side x = 1 contains the rays; its edge at z = 1 is what they meet first.
  const Judge referee(test::cube());
  const Ray along = ray_to({1, 0.3f, 3}, {0, 0, -1});
  EXPECT_EQ(judge(referee, along, kMiss), Verdict::edge);
  EXPECT_EQ(judge(referee, ray_to({next_up(1), 0.3f, 3}, {0, 0, -1}), kMiss), Verdict::right);
  // Any face that the ray slides along may be what rounding finds, at any depth.
  const ExactHit hit = referee.oracle().closest(along);
  EXPECT_EQ(judge(referee, along, hit_at(2, hit.prims[0])), Verdict::right);
  EXPECT_EQ(judge(referee, along, hit_at(3, 0)), Verdict::edge);
  EXPECT_EQ(judge(referee, along, hit_at(4, 0)), Verdict::far);
}

// Two squares over one another, offset: where the ray is near the boundary of the first, the second must still be hit.
TEST(Judge, BehindAnExcusedEdgeTheNextSurfaceMustBeHit) {
  const TriangleMesh mesh =
      make_mesh({{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}, {-5, -5, 0}, {5, -5, 0}, {5, 5, 0}, {-5, 5, 0}},
                {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}});
  const Judge referee(mesh);
  const Ray ray = ray_to({0.3f, 1, 3}, {0, 0, -1});
  EXPECT_EQ(judge(referee, ray, hit_at(2, 1)), Verdict::right);
  EXPECT_EQ(judge(referee, ray, hit_at(3, 3)), Verdict::edge);
  EXPECT_EQ(judge(referee, ray, kMiss), Verdict::miss);
  EXPECT_EQ(judge_any(referee, ray, false), Verdict::miss);
}

// A T-junction is a crack: the vertices of the long edge and of the short ones move independently.
TEST(Judge, ACrackExcusesAMiss) {
  const TriangleMesh mesh =
      make_mesh({{0, 0, 0}, {1, 0, 0}, {0.5f, 1, 0}, {0.5f, 0, 0}, {0.5f, -1, 0}}, {{0, 1, 2}, {0, 4, 3}, {3, 4, 1}});
  const Judge referee(mesh);
  EXPECT_EQ(judge(referee, ray_to({0.3f, 0, 1}, {0, 0, -1}), kMiss), Verdict::edge);
  EXPECT_EQ(judge(referee, ray_to({0.5f, -0.3f, 1}, {0, 0, -1}), kMiss), Verdict::miss);
}

TEST(Judge, TheEndsOfTheIntervalExcuse) {
  const Judge referee(test::square());
  const Vec3 org{0.75f, 0.25f, 1}, dir{0, 0, -3};
  const float third = 1.0f / 3.0f;
  for (const Ray& ray : {ray_to(org, dir, third), ray_to(org, dir, 0, third)}) {
    EXPECT_FALSE(is_failure(judge(referee, ray, kMiss)));
    EXPECT_FALSE(is_failure(judge(referee, ray, hit_at(third, 0))));
  }
  const Ray starts_after = ray_to(org, dir, next_up(third)), ends_before = ray_to(org, dir, 0, next_down(third));
  EXPECT_EQ(judge(referee, starts_after, hit_at(next_up(third), 0)), Verdict::edge);
  EXPECT_EQ(judge(referee, ends_before, hit_at(next_down(third), 0)), Verdict::edge);
  EXPECT_EQ(judge(referee, starts_after, hit_at(third, 0)), Verdict::false_hit) << "outside the interval";
  EXPECT_EQ(judge(referee, ray_to(org, dir, 0.3f, 0.4f), kMiss), Verdict::miss);
}

TEST(Judge, SurfacesThatRoundingCannotTellApartAreNeighbours) {
  const float z = next_up(1.0f);
  const TriangleMesh mesh =
      make_mesh({{0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {0, 0, z}, {1, 0, z}, {0, 1, z}, {0, 0, 1.01f}, {1, 0, 1.01f}, {0, 1, 1.01f}},
                {{0, 1, 2}, {3, 4, 5}, {6, 7, 8}});
  const Judge referee(mesh);
  const Ray ray = ray_to({0.25f, 0.25f, 0}, {0, 0, 1});
  EXPECT_EQ(judge(referee, ray, hit_at(1, 0)), Verdict::right);
  EXPECT_EQ(judge(referee, ray, hit_at(z, 1)), Verdict::neighbour);
  EXPECT_EQ(judge(referee, ray, hit_at(1.01f, 2)), Verdict::far);
}

TEST(Judge, AgreementNeedsPrimitiveAndBoundedT) {
  const Judge referee(test::square());
  const Ray ray = ray_to({0.75f, 0.25f, 3}, {0, 0, -2});
  EXPECT_TRUE(referee.agree(ray, kMiss, kMiss));
  EXPECT_TRUE(referee.agree(ray, hit_at(1.5f, 0), hit_at(next_up(1.5f), 0)));
  EXPECT_FALSE(referee.agree(ray, hit_at(1.5f, 0), kMiss));
  EXPECT_FALSE(referee.agree(ray, hit_at(1.5f, 0), hit_at(1.5f, 1)));
  EXPECT_FALSE(referee.agree(ray, hit_at(1.5f, 0), hit_at(1.5001f, 0)));
  EXPECT_FALSE(referee.agree(ray, hit_at(1.6f, 0), hit_at(1.6f, 0))) << "both wrong";
  const Ray ends = ray_to(ray.org, ray.dir, 0, 1.5f);
  EXPECT_TRUE(referee.agree(ends, hit_at(1.5f, 0), hit_at(1.5f, 0)));
  EXPECT_FALSE(referee.agree(ends, hit_at(next_up(1.5f), 0), hit_at(1.5f, 0))) << "beyond the interval, within the bound";
  EXPECT_FALSE(referee.agree(ends, hit_at(1.5f, 0), hit_at(next_up(1.5f), 0)));
}

TEST(Judge, BarycentricsThatAreNoNumbersAreWrong) {
  const Judge referee(test::square());
  const Ray ray = ray_to({0.75f, 0.25f, 3}, {0, 0, -2});
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  const Hit right{1.5f, 0.5f, 0.25f, 0};
  EXPECT_EQ(judge(referee, ray, right), Verdict::right);
  for (const Hit& wrong : {Hit{1.5f, nan, 0.25f, 0}, Hit{1.5f, 0.5f, nan, 0}, Hit{1.5f, -infinity, 0.25f, 0}}) {
    EXPECT_EQ(judge(referee, ray, wrong), Verdict::false_hit);
    EXPECT_FALSE(referee.agree(ray, wrong, wrong));
  }
}

// The watertight test keeps its promise on closed meshes and on soups, at any offset and scale; the judge must find nothing.
TEST(Judge, AcquitsTheWatertightTest) {
  for (const float offset : {0.0f, 1.0f, 1000.0f}) {
    for (const float scale : {0x1p-40f, 1.0f, 0x1p40f}) {
      for (const TriangleMesh& plain : {test::tetrahedron(), test::cube(), test::sphere(2), test::soup(200, 7)}) {
        const Vec3 centre = Vec3{offset, -offset, offset} * scale;
        const TriangleMesh mesh = test::transformed(plain, scale, centre);
        const Judge referee(mesh);
        for (const float radius : {0.5f, 3.0f}) {
          const std::vector<Ray> rays = test::edge_rays(mesh, centre, radius * scale, 400, 21);
          EXPECT_EQ(count_failures(referee, rays, test::brute_force<Watertight>(mesh, rays)), 0) << offset << " " << scale;
          const std::vector<std::uint8_t> occluded = test::brute_force_any<Watertight>(mesh, rays);
          for (std::size_t i = 0; i < rays.size(); ++i) EXPECT_FALSE(is_failure(judge_any(referee, rays[i], occluded[i])));
        }
      }
    }
  }
}

TEST(Judge, ConvictsMoellerTrumbore) {
  const Vec3 centre{1, 1, 1};
  const TriangleMesh mesh = test::transformed(test::sphere(3), 1, centre);
  const Judge referee(mesh);
  const std::vector<Ray> rays = test::edge_rays(mesh, centre, 0.5f, 20000, 31);
  const std::vector<Hit> hits = test::brute_force<MoellerTrumbore>(mesh, rays);
  std::size_t leaks = 0, found = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Verdict verdict = hits[i].valid() ? Verdict::right : judge(referee, rays[i], hits[i]);
    leaks += !hits[i].valid(), found += verdict == Verdict::miss;
  }
  EXPECT_GT(leaks, 0);
  EXPECT_EQ(found, leaks);
  EXPECT_EQ(count_failures(referee, rays, test::brute_force<Watertight>(mesh, rays)), 0);
}

}  // namespace
}  // namespace accel::validation
