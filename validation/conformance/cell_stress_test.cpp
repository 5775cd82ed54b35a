// Scenes and rays made to hurt structures of cells: axis-parallel rays in the planes of everything, along the edges of the
// scene's box, with denormal components, and from far away. Whatever differs from brute force is excused by exact arithmetic:
// no hit is missed, too far, or false.
#include "validation/conformance/method_test.h"
#include "validation/stress/stress_cells.h"

namespace accel::validation {
namespace {

class CellStress : public MethodTest {
 protected:
  void expect_no_failures(const std::string& what, const TriangleMesh& mesh, const std::vector<Ray>& rays) {
    const Judge judge(mesh);
    const AnyAccel accel = build(mesh);
    const std::vector<Hit> hits = closest(accel, rays), expected = closest(build_brute_force(mesh), rays);
    const std::vector<std::uint8_t> any = occluded(accel, rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      EXPECT_EQ(any[i] != 0, hits[i].valid()) << what << ", ray " << i;
      if (hits[i] == expected[i]) continue;
      const Verdict verdict = judge.judge(rays[i], hits[i], judge.oracle().closest(rays[i]));
      EXPECT_FALSE(is_failure(verdict)) << what << ", ray " << i << ": " << hits[i] << ", expected " << expected[i]
                                        << ", which is " << to_string(verdict);
    }
  }
};

TEST_P(CellStress, RaysInPlanes) {
  for (const StressScene& scene : cell_stress_scenes())
    expect_no_failures(scene.name, scene.mesh, cell_stress_rays(scene.mesh, 400));
}

TEST_P(CellStress, RaysInPlanesOfOtherScenes) {
  for (const StressScene& scene : stress_scenes(61)) {
    if (scene.name == "broken") continue;  // has no box
    expect_no_failures(scene.name, scene.mesh, cell_stress_rays(scene.mesh, 150));
  }
}

// Beyond the distance that padding is made for: see trace/cell_ray.h.
TEST_P(CellStress, RaysFromFarAway) {
  for (const StressScene& scene : cell_stress_scenes())
    for (const float extents : {1e2f, 1e3f})
      expect_no_failures(scene.name + " from far away", scene.mesh, far_rays(scene.mesh, extents, 100));
}

}  // namespace

ACCEL_FOR_EVERY_PROMISE(CellStress);

}  // namespace accel::validation
