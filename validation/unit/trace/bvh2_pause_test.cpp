// That pausing at a hit and resuming, from memory, from bytes or by the key alone, brings every hit of a ray once and in order.
#include "libaccel/trace/bvh2_pause.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "libaccel/build/bvh2_extras.h"
#include "libaccel/build/sbvh.h"
#include "libaccel/core/counter_rng.h"
#include "libaccel/exec/counters.h"
#include "libaccel/exec/multi_hit.h"
#include "libaccel/exec/pause.h"
#include "libaccel/geometry/moeller_trumbore.h"
#include "libaccel/geometry/watertight.h"
#include "libaccel/trace/bvh2_stack.h"
#include "scenes/procedural.h"
#include "validation/stress/random_bvh2.h"
#include "validation/stress/stress_rays.h"
#include "validation/stress/stress_scenes.h"

namespace accel {
namespace {

using testing::HasSubstr;
using validation::TreeShape;

// What a paused traversal goes through before it is resumed.
enum class Through { memory, bytes, key };

PausedTraversal passed(const Bvh2View& view, const PausedTraversal& paused, Through through) {
  if (through == Through::memory) return paused;
  if (through == Through::key) return paused.by_key_alone();
  const auto bytes = to_bytes(paused);
  const auto copy = std::make_unique<std::array<std::byte, kPausedBytes>>(bytes);
  const Result<PausedTraversal> read = paused_from_bytes(view, *copy);
  EXPECT_TRUE(read) << read.message();
  return *read;
}

template <class Traverser>
std::vector<Hit> chain(const Bvh2View& view, const Ray& ray, Through through) {
  std::vector<Hit> hits;
  NullObserver observer;
  for (PausedHit at = first_hit<Traverser>(view, ray, observer); at.hit.valid() && hits.size() < 10'000;
       at = next_hit<Traverser>(view, ray, passed(view, at.paused, through), observer)) {
    EXPECT_FALSE(at.paused.is_finished());
    hits.push_back(at.hit);
  }
  return hits;
}

// All hits in one traversal of the same tree.
template <class Test>
std::vector<Hit> all_at_once(const Bvh2& tree, const Ray& ray) {
  std::vector<Hit> hits(tree.references + 1);
  NullObserver observer;
  hits.resize(collect_hits<Bvh2Stack<Collect<Test>, Query::closest>>(tree.view(), ray, kBeforeAllHits, hits, observer));
  return hits;
}

bool same_hits(const std::vector<Hit>& a, const std::vector<Hit>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Hit)) == 0);
}

Bvh2 with_extras(Bvh2 tree, std::initializer_list<Bvh2Extras> extras) {
  BuildReport report;
  for (const Bvh2Extras e : extras) EXPECT_TRUE(add_extras(tree, e, report));
  return tree;
}

// One tree with the annotations of each pausable traverser.
struct Annotated {
  explicit Annotated(const Bvh2& tree)
      : hash(with_extras(tree, {Bvh2Extras::uncles, Bvh2Extras::hash})),
        full_hash(with_extras(tree, {Bvh2Extras::uncles, Bvh2Extras::full_hash})),
        parents(with_extras(tree, {Bvh2Extras::parents})) {}
  Bvh2 hash, full_hash, parents;
};

struct Tally {
  std::size_t rays = 0, hits = 0, most = 0, different = 0;
};

template <class T>
void expect_chains(const Bvh2& tree, const std::vector<Ray>& rays, const std::vector<std::vector<Hit>>& expected, bool by_key,
                   const char* what, Tally& tally) {
  const Status status = check_pausable<T>(tree);
  ASSERT_TRUE(status) << what << ": " << status.message();
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const std::vector<Hit> hits = chain<T>(tree.view(), rays[i], Through::memory);
    for (std::size_t h = 1; h < hits.size(); ++h)
      EXPECT_TRUE(is_before(place_of(hits[h - 1]), place_of(hits[h]))) << what << ", ray " << i << ": out of order";
    ++tally.rays, tally.hits += hits.size(), tally.most = std::max(tally.most, hits.size());
    tally.different += !same_hits(hits, expected[i]);
    EXPECT_TRUE(same_hits(hits, chain<T>(tree.view(), rays[i], Through::bytes))) << what << ", ray " << i << ": bytes";
    if (!by_key) continue;
    EXPECT_TRUE(same_hits(hits, chain<T>(tree.view(), rays[i], Through::key))) << what << ", ray " << i << ": key";
  }
}

template <class Test>
Tally expect_all_chains(const Bvh2& tree, const std::vector<Ray>& rays) {
  const Annotated annotated(tree);
  std::vector<std::vector<Hit>> expected;
  for (const Ray& ray : rays) expected.push_back(all_at_once<Test>(tree, ray));
  Tally tally;
  expect_chains<PausableHash<Test>>(annotated.hash, rays, expected, false, "hash", tally);
  expect_chains<PausableHash<Test>>(annotated.full_hash, rays, expected, false, "hash, all keys", tally);
  expect_chains<PausableFullHash<Test>>(annotated.full_hash, rays, expected, true, "all keys looked up", tally);
  expect_chains<PausableUncle<Test>>(annotated.hash, rays, expected, false, "uncle", tally);
  expect_chains<PausableSibling<Test>>(annotated.parents, rays, expected, false, "sibling", tally);
  return tally;
}

TEST(PausedTraversal, IsSmall) {
  static_assert(sizeof(PausedTraversal) == 32 && std::is_trivially_copyable_v<PausedTraversal>);
  using Full = PausableFullHash<Watertight>;
  static_assert(std::is_trivially_copyable_v<Full::State> && !StackTraverser<Full>);
  EXPECT_TRUE(PausedTraversal{}.is_finished());
}

TEST(PausedTraversal, BringsEveryHitOnceOnScenesThatHurt) {
  Tally sum;
  for (const validation::StressScene& scene : validation::stress_scenes(71)) {
    const auto built = Sbvh::build(scene.mesh, {.max_leaf_size = 2});
    ASSERT_TRUE(built) << built.message();
    SCOPED_TRACE(scene.name);
    const std::vector<Ray> rays = validation::stress_rays(scene.mesh, 60, 72);
    const Tally tally = expect_all_chains<Watertight>(built->structure, rays);
    sum.rays += tally.rays, sum.hits += tally.hits, sum.different += tally.different;
    sum.most = std::max(sum.most, tally.most);
  }
  // Where rounding moves a hit out of the box of its leaf, it is found by some ways and not by others.
  EXPECT_LE(sum.different, sum.rays / 500);
  EXPECT_GT(sum.hits, 2 * sum.rays);
  EXPECT_GT(sum.most, 40u);
}

TEST(PausedTraversal, BringsEveryHitOnceOnBuiltinScenes) {
  for (const BuiltinScene& builtin : builtin_scenes()) {
    const Result<SceneData> scene = make_builtin(std::string(builtin.name) + ":1500");
    ASSERT_TRUE(scene) << scene.message();
    const TriangleMesh mesh = *scene->one_mesh();
    const auto built = Sbvh::build(mesh, {});
    ASSERT_TRUE(built) << built.message();
    if (built->structure.depth > kMaxDepth64) continue;  // refused, as CheckPausable has it
    SCOPED_TRACE(builtin.name);
    const Tally tally = expect_all_chains<Watertight>(built->structure, validation::stress_rays(mesh, 40, 73));
    EXPECT_LE(tally.different, 1 + tally.rays / 200);
    EXPECT_GT(tally.hits, tally.rays / 2);
  }
}

TEST(PausedTraversal, BringsEveryHitOnceWithTheOtherTest) {
  const TriangleMesh mesh = validation::mesh_of(validation::random_triangles(300, 0.6f, 7));
  const auto built = Sbvh::build(mesh, {.max_leaf_size = 1});
  ASSERT_TRUE(built);
  EXPECT_GT(built->structure.references, mesh.size()) << "no triangle is in two leaves";
  const Tally tally = expect_all_chains<MoellerTrumbore>(built->structure, validation::stress_rays(mesh, 100, 74));
  EXPECT_LE(tally.different, tally.rays / 100);
}

// Keys of 32 bits and of 64, up to their last one.
TEST(PausedTraversal, BringsEveryHitOnceForKeysOfBothWidths) {
  for (const std::uint32_t depth : {1u, 2u, 4u, 30u, 31u, 32u, 33u, 62u, 63u}) {
    const TriangleMesh mesh = validation::mesh_of(validation::random_triangles(depth + 40, 0.9f, depth));
    for (const TreeShape shape : {TreeShape::left_comb, TreeShape::right_comb, TreeShape::chain, TreeShape::zigzag}) {
      SCOPED_TRACE(depth);
      const Bvh2 tree = validation::random_bvh2(mesh, depth, {.shape = shape, .leaf_size = 1, .max_depth = depth});
      ASSERT_EQ(tree.depth, depth);
      const Tally tally = expect_all_chains<Watertight>(tree, validation::stress_rays(mesh, 12, 75));
      EXPECT_LE(tally.different, 1u);
      EXPECT_GT(tally.most, 5u);
    }
  }
}

TEST(PausedTraversal, EqualHitsComeInTheOrderOfTheirNumbers) {
  const std::vector<Triangle> copies(40, Triangle{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  const TriangleMesh mesh = validation::mesh_of(copies);
  const Bvh2 tree = validation::random_bvh2(mesh, 1, {.leaf_size = 2});
  const std::vector<Ray> rays{{.org = {0.25f, 0.25f, 1}, .dir = {0, 0, -1}}};
  const Tally tally = expect_all_chains<Watertight>(tree, rays);
  EXPECT_EQ(tally.different, 0u);
  EXPECT_EQ(tally.most, copies.size());
}

TEST(PausedTraversal, AnEmptySceneAndRaysThatAreNoneAreFinished) {
  const Bvh2 empty;
  NullObserver observer;
  using T = PausableFullHash<Watertight>;
  EXPECT_TRUE(first_hit<T>(empty.view(), {.dir = {0, 0, 1}}, observer).paused.is_finished());
  const Bvh2 tree = with_extras(validation::random_bvh2(validation::mesh_of(validation::random_triangles(20, 0.5f, 1)), 1),
                                {Bvh2Extras::uncles, Bvh2Extras::full_hash});
  for (const Ray& ray : validation::invalid_rays()) {
    const PausedHit at = first_hit<T>(tree.view(), ray, observer);
    EXPECT_TRUE(!at.hit.valid() && at.paused.is_finished());
    EXPECT_FALSE(next_hit<T>(tree.view(), ray, at.paused, observer).hit.valid());
    EXPECT_FALSE(next_hit<T>(tree.view(), ray, {.key = 1, .node = tree.root}, observer).hit.valid());
  }
}

// As paths go on from where a ray has hit something: [BK16], Fig. 8.
TEST(PausedTraversal, AnotherRayFindsFromALeafWhatItFindsFromTheRoot) {
  const TriangleMesh mesh = validation::mesh_of(validation::random_triangles(400, 0.3f, 9));
  const auto built = Sbvh::build(mesh, {});
  ASSERT_TRUE(built);
  const Bvh2 tree = with_extras(built->structure, {Bvh2Extras::uncles, Bvh2Extras::full_hash});
  const std::vector<Ray> rays = validation::stress_rays(mesh, 1000, 76);
  using T = PausableFullHash<Watertight>;
  NullObserver observer;
  std::size_t found = 0;
  for (std::size_t i = 1; i < rays.size(); ++i) {
    const PausedHit at = first_hit<T>(tree.view(), rays[i - 1], observer);
    if (!at.hit.valid()) continue;
    const Hit expected = first_hit<T>(tree.view(), rays[i], observer).hit;
    const Hit hit = next_hit<T>(tree.view(), rays[i], at.paused.for_another_ray(), observer).hit;
    EXPECT_EQ(std::memcmp(&hit, &expected, sizeof hit), 0) << i;
    found += hit.valid();
  }
  EXPECT_GT(found, 200u);
}

// What the trail is kept for.
TEST(PausedTraversal, VisitsNoMoreNodesWithItsTrailThanByItsKey) {
  const TriangleMesh mesh = validation::mesh_of(validation::random_triangles(3000, 0.1f, 10));
  const auto built = Sbvh::build(mesh, {});
  ASSERT_TRUE(built);
  const Bvh2 tree = with_extras(built->structure, {Bvh2Extras::uncles, Bvh2Extras::full_hash});
  using T = PausableFullHash<Watertight>;
  std::uint64_t with_trail = 0, by_key = 0;
  for (const Ray& ray : validation::stress_rays(mesh, 300, 77)) {
    NullObserver none;
    for (PausedHit at = first_hit<T>(tree.view(), ray, none); at.hit.valid();) {
      CountingObserver trail, key;
      next_hit<T>(tree.view(), ray, at.paused.by_key_alone(), key);
      at = next_hit<T>(tree.view(), ray, at.paused, trail);
      EXPECT_LE(trail.counters.node_steps, key.counters.node_steps);
      with_trail += trail.counters.node_steps, by_key += key.counters.node_steps;
    }
  }
  EXPECT_LT(with_trail, by_key * 95 / 100);
}

class PausedBytes : public testing::Test {
 protected:
  PausedBytes()
      : tree_(with_extras(validation::random_bvh2(mesh_of_tree(), 3, {.leaf_size = 1}),
                          {Bvh2Extras::uncles, Bvh2Extras::full_hash})) {
    NullObserver observer;
    for (const Ray& ray : validation::stress_rays(mesh_of_tree(), 200, 78)) {
      const PausedHit at = first_hit<T>(tree_.view(), ray, observer);
      if (at.hit.valid() && at.paused.key > 8) ray_ = ray, paused_ = at.paused;
    }
    EXPECT_GT(paused_.key, 8u);
  }

  using T = PausableFullHash<Watertight>;
  static TriangleMesh mesh_of_tree() { return validation::mesh_of(validation::random_triangles(60, 0.5f, 11)); }
  Result<PausedTraversal> read(const PausedTraversal& paused) const {
    return paused_from_bytes(tree_.view(), to_bytes(paused));
  }

  Bvh2 tree_;
  Ray ray_;
  PausedTraversal paused_;
};

TEST_F(PausedBytes, HaveAFixedLayout) {
  const PausedTraversal paused{0x0102030405060708u, 0x1112131415161718u, 0x21222324u, {1.0f, 0x31323334u}};
  const auto bytes = to_bytes(paused);
  const unsigned char expected[kPausedBytes] = {8,    7,    6,    5,    4,    3,    2, 1, 0x18, 0x17, 0x16, 0x15, 0x14, 0x13,
                                                0x12, 0x11, 0x24, 0x23, 0x22, 0x21, 0, 0, 0x80, 0x3f, 0x34, 0x33, 0x32, 0x31};
  EXPECT_EQ(std::memcmp(bytes.data(), expected, kPausedBytes), 0);
}

TEST_F(PausedBytes, ComeBackAsTheyWere) {
  const Result<PausedTraversal> read_back = read(paused_);
  ASSERT_TRUE(read_back) << read_back.message();
  EXPECT_EQ(to_bytes(*read_back), to_bytes(paused_));
  const Result<PausedTraversal> key = read(paused_.by_key_alone());
  ASSERT_TRUE(key) << key.message();
  EXPECT_EQ(key->node, paused_.node) << "the node has been found";
  const Result<PausedTraversal> finished = read(PausedTraversal{});
  ASSERT_TRUE(finished);
  EXPECT_TRUE(finished->is_finished());
}

TEST_F(PausedBytes, ThatAreWrongAreRefusedWithAReason) {
  const auto expect_refused = [&](auto change, const char* why) {
    PausedTraversal paused = paused_;
    change(paused);
    const Result<PausedTraversal> result = read(paused);
    ASSERT_FALSE(result) << why;
    EXPECT_THAT(result.message(), HasSubstr(why));
  };
  expect_refused([](auto& p) { p.key = ~std::uint64_t{0}; }, "key");
  expect_refused([](auto& p) { p.key *= 2; }, "key");
  expect_refused([](auto& p) { p.key ^= 1; }, "node");
  expect_refused([](auto& p) { p.node = 1u << 30; }, "node");
  expect_refused([](auto& p) { p.trail = p.whole_trail() + 1; }, "trail");
  expect_refused([](auto& p) { p.after.t = std::numeric_limits<float>::quiet_NaN(); }, "t that no hit");
  expect_refused([](auto& p) { p.after.t = -2; }, "t that no hit");
  expect_refused([](auto& p) { p.after.t = std::numeric_limits<float>::infinity(); }, "t that no hit");
  for (const std::size_t size : {std::size_t{0}, kPausedBytes - 1, kPausedBytes + 1})
    EXPECT_FALSE(paused_from_bytes(tree_.view(), std::vector<std::byte>(size)));
  EXPECT_FALSE(paused_from_bytes(Bvh2{}.view(), to_bytes(paused_))) << "an empty scene has no nodes";
}

// Bytes with errors are refused, or are those of another paused traversal, which is then as good as any.
TEST_F(PausedBytes, NeverLeadOutOfTheTree) {
  const auto good = to_bytes(paused_);
  std::size_t accepted = 0;
  for (std::uint64_t i = 0; i < 20'000; ++i) {
    CounterRng rng(79, i);
    auto bytes = good;
    for (std::uint64_t changes = 1 + rng.next_below(3); changes > 0; --changes)
      bytes[rng.next_below(kPausedBytes)] ^= static_cast<std::byte>(1u << rng.next_below(8));
    if (i % 4 == 0) std::fill(bytes.begin() + 16, bytes.begin() + 20, std::byte{0xff});  // by the key alone
    if (i % 5 == 0)
      for (std::byte& b : bytes) b = static_cast<std::byte>(rng.next_below(256));
    const Result<PausedTraversal> read = paused_from_bytes(tree_.view(), bytes);
    if (!read) continue;
    ++accepted;
    CountingObserver observer;
    next_hit<T>(tree_.view(), ray_, *read, observer);
    next_hit<PausableHash<Watertight>>(tree_.view(), ray_, *read, observer);
    next_hit<PausableUncle<Watertight>>(tree_.view(), ray_, *read, observer);
    EXPECT_LE(observer.counters.node_steps, 6 * tree_.nodes.size());
  }
  EXPECT_GT(accepted, 100u);
}

TEST(CheckPausable, NamesWhatIsMissing) {
  const TriangleMesh mesh = validation::mesh_of(validation::random_triangles(200, 0.3f, 12));
  const Bvh2 plain = validation::random_bvh2(mesh, 4);
  const Status uncles = check_pausable<PausableHash<Watertight>>(plain);
  ASSERT_FALSE(uncles);
  EXPECT_THAT(uncles.message(), HasSubstr("uncles"));
  const Bvh2 pruned = with_extras(plain, {Bvh2Extras::uncles, Bvh2Extras::hash});
  const Status keys = check_pausable<PausableFullHash<Watertight>>(pruned);
  ASSERT_FALSE(keys);
  EXPECT_THAT(keys.message(), HasSubstr("all keys hashed; only those"));
  const Status parents = check_pausable<PausableSibling<Watertight>>(pruned);
  ASSERT_FALSE(parents);
  EXPECT_THAT(parents.message(), HasSubstr("parents"));
}

TEST(CheckPausable, RefusesTreesBeyondItsKeys) {
  const TriangleMesh mesh = validation::mesh_of(validation::random_triangles(100, 0.3f, 13));
  const Bvh2 deep =
      with_extras(validation::random_bvh2(mesh, 5, {.shape = TreeShape::left_comb, .leaf_size = 1, .max_depth = 64}),
                  {Bvh2Extras::uncles, Bvh2Extras::full_hash});
  ASSERT_EQ(deep.depth, 64u);
  const Status status = check_pausable<PausableFullHash<Watertight>>(deep);
  ASSERT_FALSE(status);
  EXPECT_THAT(status.message(), HasSubstr("max_depth"));
  EXPECT_FALSE(paused_from_bytes(deep.view(), to_bytes({.key = 1, .node = deep.root})));
}

}  // namespace
}  // namespace accel
