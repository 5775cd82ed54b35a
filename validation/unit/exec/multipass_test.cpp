#include "libaccel/exec/multipass.h"

#include <gtest/gtest.h>

#include <cctype>
#include <cstring>
#include <string>
#include <vector>

#include "libaccel/exec/count_rays.h"
#include "libaccel/exec/cpu.h"
#include "libaccel/rays/ray_sets.h"
#include "libaccel/registry/any_accel.h"
#include "libaccel/registry/methods.h"
#include "scenes/procedural.h"
#include "validation/unit/exec/multipass_rules.h"
#include "validation/unit/exec/soup_and_rays.h"

namespace accel {
namespace {

using test::kDeadRay;
using test::kRules;
using test::SoupAndRays;

using ClosestStack = Bvh2Stack<Watertight, Query::closest>;
using AnyStack = Bvh2Stack<Watertight, Query::any>;
using ClosestBrute = BruteForce<Watertight, Query::closest>;
using Kernel = MultipassKernel;

// A triangle soup and random rays, some of them dead; built once.
const SoupAndRays& multipass_soup() {
  static const SoupAndRays scene = [] {
    SoupAndRays s(1000, 2500);
    for (std::size_t i = 7; i < s.rays.size(); i += 50) s.rays[i] = kDeadRay;
    return s;
  }();
  return scene;
}

bool same_profile(const MultipassProfile& a, const MultipassProfile& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

// All rules, masked and compact, in one batch and in several that do not divide the rays.
std::vector<MultipassOptions> all_options() {
  std::vector<MultipassOptions> result;
  for (const MultipassRule rule : kRules)
    for (const bool compact : {false, true})
      for (const std::uint32_t batch : {1u << 18, 300u})
        result.push_back({.rule = rule, .batch_size = batch, .compact = compact});
  return result;
}

std::string name_of(const MultipassOptions& o) {
  return std::string(rule_name(o.rule)) + (o.compact ? " compact" : " masked") + ", batches of " + std::to_string(o.batch_size);
}

template <class Traverser>
void expect_multipass_hits(const typename Traverser::View& view, std::span<const Ray> rays) {
  std::vector<Hit> expected(rays.size()), hits(rays.size());
  trace_closest<Traverser>(view, rays, expected, 1);
  int threads = 1;
  for (const MultipassOptions& options : all_options()) {
    std::memset(static_cast<void*>(hits.data()), 0xab, hits.size() * sizeof(Hit));
    trace_multipass<Traverser>(view, rays, hits, options, threads);
    EXPECT_EQ(std::memcmp(hits.data(), expected.data(), hits.size() * sizeof(Hit)), 0)
        << name_of(options) << ", " << threads << " threads";
    threads = threads == 1 ? 2 : 1;
  }
}

TEST(Multipass, HitsAreTheCpusBitForBit) {
  expect_multipass_hits<ClosestStack>(multipass_soup().bvh.view(), multipass_soup().rays);
  expect_multipass_hits<AnyStack>(multipass_soup().bvh.view(), multipass_soup().rays);
}

// What follows runs as the library has compiled it for each method: here it would be compiled once more.
class MultipassMethod : public testing::TestWithParam<std::string> {
 protected:
  static AnyAccel build() {
    Result<AnyAccel> accel = AnyAccel::build(multipass_soup().mesh, GetParam());
    EXPECT_TRUE(accel) << accel.message();
    return std::move(accel).value();
  }
  static std::span<const Ray> rays() { return std::span(multipass_soup().rays).first(800); }
};

void expect_multipass_hits(const AnyAccel& accel, std::span<const Ray> rays, const std::string& test) {
  std::vector<Hit> expected(rays.size()), hits(rays.size());
  std::vector<std::uint8_t> expected_any(rays.size());
  ASSERT_TRUE(accel.closest(rays, expected, {.threads = 1, .test = test}));
  ASSERT_TRUE(accel.occluded(rays, expected_any, {.threads = 1, .test = test}));
  int threads = 1;
  for (const MultipassOptions& options : all_options()) {
    SCOPED_TRACE(name_of(options) + ", " + std::to_string(threads) + " threads");
    std::memset(static_cast<void*>(hits.data()), 0xab, hits.size() * sizeof(Hit));
    ASSERT_TRUE(accel.trace_multipass(rays, Query::closest, hits, options, {.threads = threads, .test = test}));
    EXPECT_EQ(std::memcmp(hits.data(), expected.data(), hits.size() * sizeof(Hit)), 0);
    std::memset(static_cast<void*>(hits.data()), 0xab, hits.size() * sizeof(Hit));
    ASSERT_TRUE(accel.trace_multipass(rays, Query::any, hits, options, {.threads = threads, .test = test}));
    for (std::size_t i = 0; i < rays.size(); ++i) EXPECT_EQ(hits[i].valid(), expected_any[i] != 0) << i;
    threads = threads == 1 ? 2 : 1;
  }
}

TEST_P(MultipassMethod, HitsAreTheCpusWithAllOptions) {
  const AnyAccel accel = build();
  for (const std::string& test : modelled_tests()) {
    SCOPED_TRACE(test);
    expect_multipass_hits(accel, rays(), test);
  }
}

// Whether a method leaves leaves without backtracking, as in grids.
bool goes_on_downwards(const std::string& method) {
  bool result = false;
  Methods::for_each([&](auto tag) {
    using Traverser = typename decltype(tag)::type::template Traverser<Watertight, Query::closest>;
    if constexpr (SpeculativeTraverser<Traverser>)
      result |= decltype(tag)::type::name() == method && Traverser::kAfterLeaf == Phase::descend;
  });
  return result;
}

// What the kernels did is what the while-while executor counts.
void expect_cpu_counts(const AnyAccel& accel, std::span<const Ray> rays, Query query) {
  const Counters counters = *accel.count(rays, query, {}, {.threads = 1});
  const MultipassProfile p = *accel.trace_multipass(rays, query, {}, {}, {.threads = 1});
  EXPECT_EQ(p.rays, rays.size());
  EXPECT_EQ(p.of(Kernel::initialize).rays, rays.size());
  EXPECT_EQ(p.of(Kernel::down).rays, counters.node_steps);
  if (accel.method().instances) {
    // To enter an instance is an intersect step without a test, and it may go down, or back, at once.
    EXPECT_GT(p.of(Kernel::intersect).rays, counters.triangle_tests);
    EXPECT_LE(p.of(Kernel::leaf).rays, counters.leaf_visits);
  } else if (goes_on_downwards(accel.method().name)) {
    EXPECT_EQ(p.of(Kernel::intersect).rays, counters.triangle_tests);
    EXPECT_LE(p.of(Kernel::leaf).rays, counters.leaf_visits);
  } else {
    EXPECT_EQ(p.of(Kernel::intersect).rays, counters.triangle_tests);
    EXPECT_EQ(p.of(Kernel::leaf).rays, counters.leaf_visits);
    EXPECT_EQ(p.of(Kernel::continue_search).rays, counters.leaf_visits);
    EXPECT_EQ(p.transitions(), 2 * counters.leaf_visits);
  }
  std::uint64_t fetched = 0;
  for (const Memory memory : {Memory::node, Memory::triangle, Memory::hash})
    fetched += counters.bytes[static_cast<int>(memory)];
  EXPECT_EQ(p.total().bytes_fetched, fetched);
}

// Devices visit what CPUs, which remember more postponed nodes, may drop (trace/bvh2_hash_recent.h): few, and with the same
// hits.
void expect_a_little_more_than_cpu_counts(const AnyAccel& accel, std::span<const Ray> rays) {
  const Counters counters = *accel.count(rays, Query::closest, {}, {.threads = 1});
  const MultipassProfile p = *accel.trace_multipass(rays, Query::closest, {}, {}, {.threads = 1});
  EXPECT_GE(p.of(Kernel::down).rays, counters.node_steps);
  EXPECT_LE(p.of(Kernel::down).rays, counters.node_steps + counters.node_steps / 5);
  EXPECT_GE(p.of(Kernel::intersect).rays, counters.triangle_tests);
}

TEST_P(MultipassMethod, StepsAreTheCpus) {
  const AnyAccel accel = build();
  if (accel.method().traverser == "hash") return expect_a_little_more_than_cpu_counts(accel, rays());
  expect_cpu_counts(accel, rays(), Query::closest);
  expect_cpu_counts(accel, rays(), Query::any);
}

std::vector<std::string> method_names() {
  std::vector<std::string> names;
  for (const MethodInfo& method : methods()) names.push_back(method.name);
  return names;
}

INSTANTIATE_TEST_SUITE_P(Methods, MultipassMethod, testing::ValuesIn(method_names()), [](const auto& method) {
  std::string name = method.param;
  for (char& c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  return name;
});

TEST(Multipass, ProfilesDoNotDependOnThreads) {
  const SoupAndRays& scene = multipass_soup();
  for (const MultipassOptions& options : all_options()) {
    const MultipassProfile one = trace_multipass<ClosestStack>(scene.bvh.view(), scene.rays, {}, options, 1);
    for (const int threads : {2, 3, 0})
      EXPECT_TRUE(same_profile(one, trace_multipass<ClosestStack>(scene.bvh.view(), scene.rays, {}, options, threads)))
          << name_of(options);
  }
}

// N triangles and no tree: N passes of Intersect and one of each transition, whose every figure is known.
TEST(Multipass, BruteForceByHand) {
  const auto mesh = make_builtin("soup:20")->mesh;
  const auto list = ListBuilder::build(mesh, {})->structure;
  std::vector<Ray> rays(multipass_soup().rays.begin() + 10, multipass_soup().rays.begin() + 50);
  for (std::size_t i = 0; i < 8; ++i) rays[i] = kDeadRay;  // the first warp keeps 24 rays, the second all of its 8
  const MultipassProfile p = trace_multipass<ClosestBrute>(list.view(), rays, {}, {}, 1);
  constexpr std::uint64_t kState = sizeof(ClosestBrute::State);
  const std::uint64_t triangles = mesh.size();
  for (const auto& [kernel, passes, live] : {std::tuple{Kernel::initialize, std::uint64_t{1}, 40u},
                                             {Kernel::down, std::uint64_t{0}, 0u},
                                             {Kernel::leaf, std::uint64_t{1}, 32u},
                                             {Kernel::intersect, triangles, 32u},
                                             {Kernel::continue_search, std::uint64_t{1}, 32u},
                                             {Kernel::up, std::uint64_t{0}, 0u}}) {
    SCOPED_TRACE(kernel_name(kernel));
    EXPECT_EQ(p.of(kernel).passes, passes);
    EXPECT_EQ(p.of(kernel).rays, passes * live);
    EXPECT_EQ(p.of(kernel).width, passes * 40);
    EXPECT_EQ(p.of(kernel).warps, passes * 2);
    EXPECT_EQ(p.of(kernel).bytes_schedule, p.of(kernel).width + p.of(kernel).rays);
  }
  EXPECT_EQ(p.switches, 4u);
  EXPECT_EQ(p.of(Kernel::initialize).bytes_read, 40 * sizeof(Ray));
  EXPECT_EQ(p.of(Kernel::initialize).bytes_written, 40 * (kState + sizeof(Hit)));
  EXPECT_EQ(p.of(Kernel::intersect).bytes_read, triangles * 32 * (sizeof(Ray) + kState + sizeof(Hit)));
  EXPECT_EQ(p.of(Kernel::intersect).bytes_written, triangles * 32 * (kState + sizeof(Hit)));
  EXPECT_EQ(p.of(Kernel::leaf).bytes_recirculated(), 0u);
  EXPECT_EQ(p.of(Kernel::continue_search).bytes_recirculated(), 32 * 2 * sizeof(Hit)) << "rays that end touch their hit";
  EXPECT_EQ(p.of(Kernel::intersect).utilisation(), 0.8);
  EXPECT_EQ(p.of(Kernel::intersect).warp_utilisation(), 0.5);
}

TEST(Multipass, CompactionChangesWhatPassesRunOverAndNothingElse) {
  const SoupAndRays& scene = multipass_soup();
  for (const MultipassRule rule : kRules) {
    const auto masked = trace_multipass<ClosestStack>(scene.bvh.view(), scene.rays, {}, {.rule = rule}, 2);
    const auto compact = trace_multipass<ClosestStack>(scene.bvh.view(), scene.rays, {}, {.rule = rule, .compact = true}, 2);
    EXPECT_EQ(masked.switches, compact.switches);
    for (int k = 0; k < kMultipassKernels; ++k) {
      const auto &m = masked.kernels[k], &c = compact.kernels[k];
      EXPECT_EQ(m.passes, c.passes);
      EXPECT_EQ(m.rays, c.rays);
      EXPECT_EQ(m.bytes_read, c.bytes_read);
      EXPECT_EQ(m.bytes_written, c.bytes_written);
      EXPECT_EQ(m.bytes_fetched, c.bytes_fetched);
      EXPECT_EQ(m.width, m.passes * scene.rays.size());
      EXPECT_EQ(c.width, c.rays);
      EXPECT_LE(c.warps, m.warps);
    }
    EXPECT_LT(masked.total().utilisation(), 1.0);
    EXPECT_EQ(compact.total().utilisation(), 1.0);
  }
}

// Stacks stay where they are: their entries are moved, not all of them in every pass.
TEST(Multipass, StacksCostTheirEntries) {
  const SoupAndRays& scene = multipass_soup();
  const Counters counters = count_rays<ClosestStack>(scene.bvh.view(), scene.rays, {}, 1);
  const MultipassProfile p = trace_multipass<ClosestStack>(scene.bvh.view(), scene.rays, {}, {}, 1);
  constexpr std::uint64_t kCarried = sizeof(ClosestStack::State) + sizeof(Hit);
  const auto& down = p.of(Kernel::down);
  const std::uint64_t pushed = down.bytes_written - down.rays * kCarried;
  std::uint64_t popped = 0;
  for (const Kernel kernel : {Kernel::continue_search, Kernel::up})
    popped += p.of(kernel).bytes_read - p.of(kernel).rays * (sizeof(Ray) + kCarried);
  EXPECT_GT(pushed, 0u);
  EXPECT_EQ(pushed + popped, counters.bytes[static_cast<int>(Memory::stack)]);
}

TEST(Multipass, BatchesBoundTheMemory) {
  const SoupAndRays& scene = multipass_soup();
  const auto profile = [&](std::uint32_t batch_size) {
    return trace_multipass<ClosestStack>(scene.bvh.view(), scene.rays, {}, {.batch_size = batch_size}, 1);
  };
  const MultipassProfile whole = profile(1u << 18), parts = profile(1000), ones = profile(0);
  EXPECT_EQ(whole.batches, 1u);
  EXPECT_EQ(parts.batches, 3u);
  EXPECT_EQ(ones.batches, scene.rays.size()) << "a batch has at least one ray";
  EXPECT_EQ(whole.total().rays, parts.total().rays);
  EXPECT_EQ(whole.total().rays, ones.total().rays);
  EXPECT_LT(parts.bytes_in_flight, whole.bytes_in_flight);
  EXPECT_EQ(parts.bytes_in_flight / 1000, ones.bytes_in_flight);
  EXPECT_EQ(ones.total().utilisation(), 1.0) << "a batch of one ray has no one to wait for";
}

TEST(Multipass, FewerSwitchesWhereKernelsAreDrained) {
  const SoupAndRays& scene = multipass_soup();
  const auto profile = [&](MultipassRule rule) {
    return trace_multipass<ClosestStack>(scene.bvh.view(), scene.rays, {}, {.rule = rule}, 1);
  };
  const MultipassProfile delany = profile(MultipassRule::delany), drain = profile(MultipassRule::drain);
  EXPECT_LT(drain.switches, delany.switches);
  EXPECT_GT(drain.total().passes, delany.total().passes);
}

TEST(Multipass, NoRaysNoPasses) {
  for (const bool compact : {false, true}) {
    const MultipassProfile p = trace_multipass<ClosestStack>(multipass_soup().bvh.view(), {}, {}, {.compact = compact}, 1);
    EXPECT_TRUE(same_profile(p, MultipassProfile{}));
    EXPECT_EQ(p.total().utilisation(), 1.0);
  }
}

}  // namespace
}  // namespace accel
