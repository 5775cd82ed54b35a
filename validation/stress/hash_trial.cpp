#include "validation/stress/hash_trial.h"

#include <array>
#include <iterator>

#include "libaccel/build/bvh2_hash.h"
#include "libaccel/core/counter_rng.h"
#include "validation/stress/stress_scenes.h"

namespace accel::validation {
namespace {

const TriangleMesh& mesh_of_size(std::uint32_t which) {
  static const std::array<TriangleMesh, 5> meshes = [] {
    std::array<TriangleMesh, 5> result;
    constexpr int kSizes[] = {1, 9, 40, 160, 1000};
    for (std::size_t i = 0; i < result.size(); ++i) result[i] = mesh_of(random_triangles(kSizes[i], 0.3f, i));
    return result;
  }();
  return meshes[which];
}

// Large trees are rare: they take most of the time.
std::uint32_t pick_mesh(CounterRng& rng) {
  const std::uint32_t dice = rng.next_below(1000);
  return dice < 10 ? 0u : dice < 300 ? 1u : dice < 800 ? 2u : dice < 995 ? 3u : 4u;
}

}  // namespace

HashTrial try_hash(std::uint64_t number) {
  CounterRng rng(11, number);
  const TriangleMesh& mesh = mesh_of_size(pick_mesh(rng));
  HashTrial trial{};
  trial.shape = kTreeShapes[rng.next_below(static_cast<std::uint32_t>(std::size(kTreeShapes)))];
  trial.which = rng.next_below(2) == 0 ? HashedKeys::looked_up : HashedKeys::all;
  Bvh2 tree = random_bvh2(mesh, number, {.shape = trial.shape, .leaf_size = 1 + rng.next_below(3)});
  trial.depth = tree.depth, trial.keys = 2 * tree.nodes.size();
  BuildReport report;
  trial.status = add_hash(tree, trial.which, report);
  if (trial.status) trial.status = validate(tree, mesh.size());
  trial.bytes = tree.displacements.size_bytes() + tree.slots.size_bytes();
  return trial;
}

}  // namespace accel::validation
