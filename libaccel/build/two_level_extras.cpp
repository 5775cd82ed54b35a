#include "libaccel/build/two_level_extras.h"

#include <string>
#include <vector>

#include "libaccel/build/bvh2_extras.h"

namespace accel {
namespace {

bool is_hash(Bvh2Extras extras) { return extras == Bvh2Extras::hash || extras == Bvh2Extras::full_hash; }

BuildNote note_of_tables(const TwoLevelBvh& bvh) {
  std::size_t with_tables = 0, wide = 0;
  for (const TwoLevelTree& tree : bvh.trees) with_tables += tree.displacements > 0, wide += tree.depth > kMaxDepth32;
  return {"hash tables", "of " + std::to_string(with_tables) + " of " + std::to_string(bvh.trees.size()) +
                             " trees (where there is none, no key can be looked up), with 64-bit keys for " +
                             std::to_string(wide) +
                             " of them: " + std::to_string(bvh.displacements.size_bytes() + bvh.slots.size_bytes()) + " bytes"};
}

}  // namespace

Status add_extras(TwoLevelBvh& bvh, Bvh2Extras extras, BuildReport& report) {
  std::vector<Bvh2> trees;
  std::vector<std::uint64_t> triangles;
  for (std::size_t i = 0; i < bvh.trees.size(); ++i) {
    trees.push_back(bvh.tree(i));
    triangles.push_back(bvh.trees[i].triangles);
    if (trees.back().has(extras)) continue;
    BuildReport of_tree;
    if (const Status added = add_extras(trees.back(), extras, of_tree); !added) return added;
  }
  Buffer<TwoLevelInstance> instances = bvh.instances;
  bvh = TwoLevelBvh::join(trees, triangles);
  bvh.instances = std::move(instances);
  if (is_hash(extras)) report.notes.push_back(note_of_tables(bvh));
  return Done{};
}

}  // namespace accel
