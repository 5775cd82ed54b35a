#include "libaccel/build/two_level_extras.h"

#include <gtest/gtest.h>

#include <cstring>

#include "libaccel/build/bvh2_extras.h"
#include "validation/stress/stress_instances.h"
#include "validation/unit/build/built_instances.h"

namespace accel {
namespace {

using test::built;

template <class Array>
bool same(const Array& a, const Array& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

// Every tree gets what it would get by itself.
TEST(TwoLevelExtras, AreThoseOfEachTree) {
  for (const auto& s : validation::instanced_scenes()) {
    for (const Bvh2Extras extras : TwoLevelBvh::kExtras) {
      const TwoLevelBvh plain = built(s.scene);
      TwoLevelBvh bvh = plain;
      BuildReport report;
      ASSERT_TRUE(add_extras(bvh, extras, report)) << s.name;
      EXPECT_TRUE(bvh.has(extras)) << s.name;
      const Status valid = validate(bvh, s.scene.size());
      EXPECT_TRUE(valid) << s.name << ": " << valid.message();
      EXPECT_TRUE(same(bvh.instances, plain.instances)) << s.name;
      ASSERT_EQ(bvh.trees.size(), plain.trees.size());
      for (std::size_t i = 0; i < plain.trees.size(); ++i) {
        Bvh2 expected = plain.tree(i);
        ASSERT_TRUE(add_extras(expected, extras, report));
        const Bvh2 tree = bvh.tree(i);
        EXPECT_TRUE(same(tree.nodes, expected.nodes)) << s.name << ", tree " << i;
        EXPECT_TRUE(same(tree.leaves, expected.leaves)) << s.name << ", tree " << i;
        EXPECT_TRUE(same(tree.displacements, expected.displacements)) << s.name << ", tree " << i;
        EXPECT_TRUE(same(tree.slots, expected.slots)) << s.name << ", tree " << i;
      }
    }
  }
}

TEST(TwoLevelExtras, StructuresThatShareArraysKeepTheirs) {
  const TwoLevelBvh plain = built(validation::instanced_scenes()[7].scene);
  const TwoLevelBvh before = plain;
  TwoLevelBvh bvh = plain;
  BuildReport report;
  ASSERT_TRUE(add_extras(bvh, Bvh2Extras::uncles, report));
  EXPECT_EQ(before.nodes.data(), plain.nodes.data());
  EXPECT_FALSE(plain.has(Bvh2Extras::uncles));
  EXPECT_TRUE(validate(plain, validation::instanced_scenes()[7].scene.size()));
}

TEST(TwoLevelExtras, OneNoteTellsOfAllTables) {
  TwoLevelBvh bvh = built(validation::instanced_scenes()[7].scene);
  BuildReport report;
  ASSERT_TRUE(add_extras(bvh, Bvh2Extras::hash, report));
  ASSERT_EQ(report.notes.size(), 1u);
  EXPECT_EQ(report.notes[0].what, "hash tables");
}

}  // namespace
}  // namespace accel
