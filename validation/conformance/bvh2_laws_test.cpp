// The laws of Binder and Keller 2016 and of the other traversers of two-box BVHs: which nodes, leaves and triangles they visit,
// in which order, compared with the stack version.
//
// A traverser without a stack has no room for distances, so it enters postponed nodes that the stack version drops unread. So
// hash, uncle and sibling visit what the stack version visits when it drops none, exactly; hash with the distance in its
// register, or with the mask, drops some of what the stack version drops; the more nodes it remembers, the more, and all of it
// when none is forgotten. Parent tests boxes again and visits
// what the stack version visits, exactly. Restart-trail visits the leaves that the stack version visits.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

#include "libaccel/build/bvh2_extras.h"
#include "libaccel/build/sbvh.h"
#include "libaccel/exec/drive.h"
#include "libaccel/geometry/watertight.h"
#include "libaccel/trace/bvh2_hash.h"
#include "libaccel/trace/bvh2_hash_recent.h"
#include "libaccel/trace/bvh2_parent.h"
#include "libaccel/trace/bvh2_restart_trail.h"
#include "libaccel/trace/bvh2_sibling.h"
#include "libaccel/trace/bvh2_skip.h"
#include "libaccel/trace/bvh2_stack.h"
#include "libaccel/trace/bvh2_uncle.h"
#include "scenes/procedural.h"
#include "validation/stress/random_bvh2.h"
#include "validation/stress/stress_rays.h"
#include "validation/stress/stress_scenes.h"

namespace accel::validation {
namespace {

// What a traversal did, in order.
struct Bvh2Record {
  std::vector<const void*> nodes;
  std::vector<std::uint32_t> leaves;
  std::vector<const void*> triangles;
  std::uint64_t backtracks = 0, look_ups = 0, stack_bytes = 0;
  Hit hit;
};

struct Bvh2Recorder : NullObserver {
  Bvh2Record record;
  bool visits = false;

  void load(Memory memory, const void* address, std::uint32_t bytes) {
    if (memory == Memory::triangle && bytes == sizeof(PackedTriangle)) record.triangles.push_back(address);
    if (memory == Memory::node && visits) record.nodes.push_back(address), visits = false;
    if (memory == Memory::hash) ++record.look_ups;
    if (memory == Memory::stack) record.stack_bytes += bytes;
  }
  void node_step() { visits = true; }
  void leaf_visit(std::uint32_t quad) { record.leaves.push_back(quad); }
  void backtrack() { ++record.backtracks; }
};

template <class Traverser>
Bvh2Record bvh2_record_of(const Bvh2View& view, const Ray& ray) {
  Bvh2Recorder observer;
  observer.record.hit = trace_ray<Traverser>(view, ray, observer);
  return observer.record;
}

bool same_bits(const Hit& a, const Hit& b) { return std::memcmp(&a, &b, sizeof(Hit)) == 0; }

void expect_same(const Bvh2Record& record, const Bvh2Record& stack, const char* traverser) {
  EXPECT_EQ(record.nodes, stack.nodes) << traverser;
  EXPECT_EQ(record.leaves, stack.leaves) << traverser;
  EXPECT_EQ(record.triangles, stack.triangles) << traverser;
  EXPECT_TRUE(same_bits(record.hit, stack.hit)) << traverser;
}

// Whether the second has all elements of the first, in its order.
template <class T>
bool is_within(const std::vector<T>& part, const std::vector<T>& whole) {
  auto at = whole.begin();
  for (const T& element : part) {
    at = std::find(at, whole.end(), element);
    if (at == whole.end()) return false;
    ++at;
  }
  return true;
}

// Some of what may be dropped has been, in the same order.
void expect_between(const Bvh2Record& record, const Bvh2Record& dropping, const Bvh2Record& stack, const char* traverser) {
  EXPECT_TRUE(is_within(dropping.nodes, record.nodes)) << traverser;
  EXPECT_TRUE(is_within(record.nodes, stack.nodes)) << traverser;
  EXPECT_TRUE(is_within(dropping.leaves, record.leaves)) << traverser;
  EXPECT_TRUE(is_within(record.leaves, stack.leaves)) << traverser;
  EXPECT_TRUE(same_bits(record.hit, stack.hit)) << traverser;
}

// Trees with each kind of annotation, over one tree.
class Bvh2LawsOf {
 public:
  Bvh2LawsOf(std::string name, const Bvh2& tree)
      : name_(std::move(name)), plain_(tree), parents_(tree), uncles_(tree), all_hashed_(tree) {
    BuildReport report;
    add_links(parents_, Bvh2Links::parents);
    add_links(uncles_, Bvh2Links::uncles);
    EXPECT_TRUE(add_hash(uncles_, HashedKeys::looked_up, report));
    EXPECT_TRUE(add_hash(all_hashed_, HashedKeys::all, report));
    add_skips(parents_), add_octant_skips(parents_);
    for (const Bvh2* annotated : {&parents_, &uncles_, &all_hashed_}) {
      const Status valid = validate(*annotated, kNoHit);
      EXPECT_TRUE(valid) << name_ << ": " << (valid ? "" : valid.message());
    }
    // Traversals of trees with links visit copies of the nodes: addresses are compared relative to the nodes.
    parents_view_ = parents_.view(), uncles_view_ = uncles_.view(), all_hashed_view_ = all_hashed_.view();
  }

  void check(const std::vector<Ray>& rays) {
    for (std::size_t i = 0; i < rays.size() && !testing::Test::HasFailure(); ++i) {
      SCOPED_TRACE(name_ + ", ray " + std::to_string(i));
      check<Query::closest>(rays[i]);
      check<Query::any>(rays[i]);
    }
  }
  std::uint64_t look_ups() const { return look_ups_; }
  std::uint64_t look_ups_of_one() const { return look_ups_of_one_; }
  std::uint64_t look_ups_of_four() const { return look_ups_of_four_; }

 private:
  // Addresses as offsets.
  template <class Traverser>
  Bvh2Record record(const Bvh2& tree, const Bvh2View& view, const Ray& ray) const {
    Bvh2Record result = bvh2_record_of<Traverser>(view, ray);
    for (const void*& p : result.nodes)
      p = reinterpret_cast<const void*>(static_cast<const char*>(p) - reinterpret_cast<const char*>(tree.nodes.data()));
    for (const void*& p : result.triangles)
      p = reinterpret_cast<const void*>(static_cast<const char*>(p) - reinterpret_cast<const char*>(tree.leaves.data()));
    return result;
  }

  template <Query kQuery>
  void check(const Ray& ray) {
    // Beyond the stack's depth, parent and sibling stand in, which keep no path: so far they are its equals.
    const bool fits = plain_.depth <= Bvh2Stack<Watertight, kQuery>::kMaxDepth;
    const Bvh2Record dropping = fits ? record<Bvh2StackWith<Watertight, kQuery, true>>(plain_, plain_.view(), ray)
                                     : record<Bvh2Parent<Watertight, kQuery>>(parents_, parents_view_, ray);
    const Bvh2Record stack = fits ? record<Bvh2StackWith<Watertight, kQuery, false>>(plain_, plain_.view(), ray)
                                  : record<Bvh2SiblingWith<Watertight, kQuery, DeepPath>>(parents_, parents_view_, ray);
    EXPECT_TRUE(same_bits(stack.hit, dropping.hit));
    EXPECT_TRUE(is_within(dropping.nodes, stack.nodes));

    check_path<DeepPath, kQuery>(ray, stack, dropping);
    if (plain_.depth <= kMaxDepth32) check_path<NodePath<std::uint32_t>, kQuery>(ray, stack, dropping);
    if (plain_.depth <= kMaxDepth64) check_path<NodePath<std::uint64_t>, kQuery>(ray, stack, dropping);
    if (plain_.depth <= kMaxDepth64) check_shallow_trail<kQuery>(ray, dropping);
    if (plain_.depth <= kMaxDepth32) check_recent<PackedPath, kQuery>(ray, stack, dropping);
    if (plain_.depth <= kMaxDepth64) check_recent<NodePath<std::uint64_t>, kQuery>(ray, stack, dropping);

    expect_same(record<Bvh2Parent<Watertight, kQuery>>(parents_, parents_view_, ray), dropping, "parent");
    check_trail<true, 0, kQuery>(ray, dropping);
    check_skips<Bvh2Skip<Watertight, kQuery>>(ray, stack.hit, kQuery);
    check_skips<Bvh2SkipOctant<Watertight, kQuery>>(ray, stack.hit, kQuery);
  }

  template <class Path, Query kQuery>
  void check_path(const Ray& ray, const Bvh2Record& stack, const Bvh2Record& dropping) {
    using NoRegister = Bvh2HashOptions<false>;
    using NoDistance = Bvh2HashOptions<true, false, false>;
    const Bvh2Record hash = record<Bvh2HashWith<Watertight, kQuery, Path, NoDistance>>(uncles_, uncles_view_, ray);
    expect_same(hash, stack, "hash, no distance");
    const Bvh2Record with_distance = record<Bvh2HashWith<Watertight, kQuery, Path>>(uncles_, uncles_view_, ray);
    expect_between(with_distance, dropping, stack, "hash");
    look_ups_ += hash.look_ups;
    EXPECT_LE(hash.look_ups, 2 * hash.backtracks);
    expect_same(record<Bvh2HashWith<Watertight, kQuery, Path, NoRegister>>(all_hashed_, all_hashed_view_, ray), stack,
                "hash, no register");
    expect_same(record<Bvh2UncleWith<Watertight, kQuery, Path>>(uncles_, uncles_view_, ray), stack, "uncle");
    expect_same(record<Bvh2SiblingWith<Watertight, kQuery, Path>>(parents_, parents_view_, ray), stack, "sibling");
    if constexpr (!std::is_same_v<Path, DeepPath>) {
      const Bvh2Record masked =
          record<Bvh2HashWith<Watertight, kQuery, Path, Bvh2HashOptions<true, true>>>(uncles_, uncles_view_, ray);
      expect_between(masked, dropping, stack, "mask");
    }
  }

  // Hash that remembers several nodes.
  template <class Path, Query kQuery, std::uint32_t kCount>
  Bvh2Record check_recent(const Ray& ray, const Bvh2Record& stack, const Bvh2Record& dropping) {
    const Bvh2Record recent = record<Bvh2HashRecentWith<Watertight, kQuery, Path, kCount>>(uncles_, uncles_view_, ray);
    expect_between(recent, dropping, stack, "recent");
    EXPECT_LE(recent.look_ups, 2 * recent.backtracks);
    return recent;
  }
  template <class Path, Query kQuery>
  void check_recent(const Ray& ray, const Bvh2Record& stack, const Bvh2Record& dropping) {
    const Bvh2Record one = check_recent<Path, kQuery, 1>(ray, stack, dropping),
                     four = check_recent<Path, kQuery, 4>(ray, stack, dropping),
                     all = check_recent<Path, kQuery, 64>(ray, stack, dropping);
    EXPECT_TRUE(is_within(four.nodes, one.nodes) && is_within(four.leaves, one.leaves));
    EXPECT_EQ(all.look_ups, 0u) << "nothing is forgotten";
    expect_same(all, dropping, "a ring that is long enough is a stack");
    look_ups_of_one_ += one.look_ups, look_ups_of_four_ += four.look_ups;
  }

  template <bool kDeep, std::uint32_t kShort, Query kQuery>
  Bvh2Record check_trail(const Ray& ray, const Bvh2Record& dropping) {
    const Bvh2Record trail = record<Bvh2RestartTrailWith<Watertight, kQuery, kDeep, kShort>>(plain_, plain_.view(), ray);
    EXPECT_EQ(trail.leaves, dropping.leaves) << "trail";
    EXPECT_EQ(trail.triangles, dropping.triangles) << "trail";
    EXPECT_TRUE(is_within(dropping.nodes, trail.nodes)) << "trail";
    EXPECT_TRUE(same_bits(trail.hit, dropping.hit)) << "trail";
    return trail;
  }
  template <Query kQuery>
  void check_shallow_trail(const Ray& ray, const Bvh2Record& dropping) {
    const Bvh2Record none = check_trail<false, 0, kQuery>(ray, dropping), some = check_trail<false, 4, kQuery>(ray, dropping),
                     many = check_trail<false, 64, kQuery>(ray, dropping);
    EXPECT_LE(some.nodes.size(), none.nodes.size());
    EXPECT_EQ(many.nodes, dropping.nodes) << "a short stack that is long enough is a stack";
  }

  template <class Traverser>
  void check_skips(const Ray& ray, const Hit& hit, Query query) {
    const Hit found = record<Traverser>(parents_, parents_view_, ray).hit;
    if (query == Query::any)
      EXPECT_EQ(found.valid(), hit.valid()) << Traverser::kName;
    else
      EXPECT_TRUE(same_bits(found, hit)) << Traverser::kName;
  }

  std::string name_;
  Bvh2 plain_, parents_, uncles_, all_hashed_;
  Bvh2View parents_view_, uncles_view_, all_hashed_view_;
  std::uint64_t look_ups_ = 0;
  std::uint64_t look_ups_of_one_ = 0, look_ups_of_four_ = 0;  // of rings with so many nodes
};

TEST(Bvh2Laws, OnRandomTreesOverScenesThatHurt) {
  std::uint64_t look_ups = 0, of_one = 0, of_four = 0;
  for (const StressScene& scene : stress_scenes(61)) {
    for (const TreeShape shape : {TreeShape::balanced, TreeShape::random, TreeShape::skewed}) {
      Bvh2LawsOf laws(scene.name, random_bvh2(scene.mesh, 62, {.shape = shape}));
      laws.check(stress_rays(scene.mesh, 60, 63));
      look_ups += laws.look_ups(), of_one += laws.look_ups_of_one(), of_four += laws.look_ups_of_four();
    }
  }
  EXPECT_GT(look_ups, 1000u) << "the test would say nothing about the hash";
  EXPECT_GT(of_four, 1000u) << "nor about nodes that rings forget";
  EXPECT_LT(of_four, of_one / 2);  // on the whole, not for every ray
}

TEST(Bvh2Laws, OnBuiltTrees) {
  for (const BuiltinScene& builtin : builtin_scenes()) {
    const Result<SceneData> scene = make_builtin(std::string(builtin.name) + ":1000");
    ASSERT_TRUE(scene) << scene.message();
    const TriangleMesh mesh = *scene->one_mesh();
    const auto built = Sbvh::build(mesh, {.max_leaf_size = 2});
    ASSERT_TRUE(built);
    Bvh2LawsOf(std::string(builtin.name), built->structure).check(stress_rays(mesh, 100, 64));
  }
}

// Depths on both sides of every change of width, and far beyond.
TEST(Bvh2Laws, OnDeepTrees) {
  for (const std::uint32_t depth : {30u, 31u, 32u, 62u, 63u, 64u, 93u, 94u, 95u, 126u, 300u}) {
    const TriangleMesh mesh = mesh_of(random_triangles(depth + 40, 0.7f, depth));
    for (const TreeShape shape : {TreeShape::left_comb, TreeShape::right_comb, TreeShape::chain, TreeShape::zigzag}) {
      const Bvh2 tree = random_bvh2(mesh, depth, {.shape = shape, .leaf_size = 1, .max_depth = depth});
      EXPECT_EQ(tree.depth, depth);
      Bvh2LawsOf("depth " + std::to_string(depth), tree).check(stress_rays(mesh, 20, 65));
    }
  }
}

// States are as small as the methods promise: what a paused ray costs beyond what every traversal knows of its ray.
template <class Traverser>
constexpr std::size_t own_bytes() {
  return sizeof(typename Traverser::State) - sizeof(Bvh2State<Watertight>);
}
using Narrow = NodePath<std::uint32_t>;
using Wide = NodePath<std::uint64_t>;
static_assert(own_bytes<Bvh2HashWith<Watertight, Query::closest, Narrow>>() <= 32);
static_assert(own_bytes<Bvh2HashWith<Watertight, Query::closest, Wide>>() <= 32);
static_assert(own_bytes<Bvh2HashWith<Watertight, Query::closest, DeepPath>>() <= 48);
using Recent = Bvh2HashRecentWith<Watertight, Query::closest, PackedPath, kRecentNodes>;
static_assert(own_bytes<Recent>() <= 32 && sizeof(StackOf<Recent>) == 32);
static_assert(own_bytes<Bvh2UncleWith<Watertight, Query::closest, Narrow>>() <= 32);
static_assert(own_bytes<Bvh2SiblingWith<Watertight, Query::closest, Narrow>>() <= 16);
static_assert(own_bytes<Bvh2Parent<Watertight, Query::closest>>() <= 16);
static_assert(own_bytes<Bvh2Skip<Watertight, Query::closest>>() <= 16);
static_assert(own_bytes<Bvh2RestartTrailWith<Watertight, Query::closest, false, 0>>() <= 48);
static_assert(!StackTraverser<Bvh2HashWith<Watertight, Query::closest, Wide>>);
static_assert(StackTraverser<Bvh2HashWith<Watertight, Query::closest, DeepPath>>);
static_assert(std::is_trivially_copyable_v<Bvh2Hash<Watertight, Query::closest>::State>);

}  // namespace
}  // namespace accel::validation
