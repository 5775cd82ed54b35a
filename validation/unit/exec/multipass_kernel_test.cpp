// The source of the multipass kernels on the CPU's emulated warps, against the CPU executor. What a device does: see
// cuda_test.cpp.
#include <gtest/gtest.h>

#include <cstring>
#include <vector>

#include "libaccel/exec/cpu.h"
#include "libaccel/exec/multipass_schedule.h"
#include "libaccel/rays/ray_sets.h"
#include "libaccel/registry/annotate.h"
#include "scenes/procedural.h"
#include "validation/unit/exec/kernel_methods.h"
#include "validation/unit/exec/warp_emulator.h"
// The kernels need the emulator's intrinsics.
#include "libaccel/exec/cuda/multipass_kernel.cuh"

namespace accel {
namespace {

using cuda::KeepHits;
using cuda::MultipassLists;
using cuda::MultipassStreams;
using cuda::StoreOccluded;

// Rays in lists of our own, as exec/cuda/launch_multipass.cuh has them on the device.
template <class Traverser, class Finish>
class EmulatedRun {
 public:
  EmulatedRun(const typename Traverser::View& view, const std::vector<Ray>& rays, std::vector<Hit>& hits, const Finish& finish)
      : view_(view), finish_(finish), states_(rays.size()), stacks_(rays.size()), phases_(rays.size()) {
    streams_ = {rays.data(), hits.data(), states_.data(), stacks_.data(), phases_.data()};
  }

  void run(MultipassRule rule) {
    const auto count = static_cast<std::uint32_t>(states_.size());
    const auto pass = [this](MultipassKernel kernel, MultipassCounts& waiting) -> Status {
      const std::uint32_t* list = lists_.begin_pass(kernel);
      sizes_[static_cast<std::size_t>(kernel)] = 0;
      visit_kernel(kernel, [&](auto k) { launch<k()>(list, waiting[kernel]); });
      for (int i = 0; i < kMultipassKernels; ++i) waiting[static_cast<MultipassKernel>(i)] = sizes_[i];
      return Done{};
    };
    EXPECT_TRUE(run_passes(rule, count, pass).ok());
  }

 private:
  template <MultipassKernel kKernel>
  void launch(const std::uint32_t* list, std::uint32_t count) {
    run_warps((count + 31) / 32,
              [&] { cuda::multipass_kernel<Traverser, kKernel, Finish>(view_, streams_, list, count, lists_, finish_); });
  }

  const typename Traverser::View& view_;
  const Finish finish_;
  std::vector<typename Traverser::State> states_;
  std::vector<StackOf<Traverser>> stacks_;
  std::vector<Phase> phases_;
  MultipassStreams<Traverser> streams_;
  std::vector<std::uint32_t> list_memory_ = std::vector<std::uint32_t>((kMultipassKernels + 1) * states_.size());
  std::uint32_t sizes_[kMultipassKernels] = {};
  MultipassLists lists_{list_memory_.data(), states_.size(), sizes_};
};

template <class Method>
void expect_cpu_answers(const TriangleMesh& mesh, const std::vector<Ray>& rays) {
  using Closest = typename Method::template Traverser<Watertight, Query::closest>;
  using Any = typename Method::template Traverser<Watertight, Query::any>;
  SCOPED_TRACE(Method::name());
  const auto built = build_for<Method>(mesh, {});
  ASSERT_TRUE(built.ok()) << built.message();
  const auto view = built->structure.view();
  const std::size_t count = rays.size();
  std::vector<Hit> expected(count), hits(count);
  std::vector<std::uint8_t> expected_any(count), any(count, 2);
  trace_closest<Closest>(view, rays, expected, 1);
  trace_any<Any>(view, rays, expected_any, 1);

  std::memset(static_cast<void*>(hits.data()), 0xab, count * sizeof(Hit));
  EmulatedRun<Closest, KeepHits>(view, rays, hits, KeepHits{}).run(MultipassRule::delany);
  EXPECT_EQ(std::memcmp(hits.data(), expected.data(), count * sizeof(Hit)), 0);
  EmulatedRun<Any, StoreOccluded>(view, rays, hits, StoreOccluded{any.data()}).run(MultipassRule::delany);
  EXPECT_EQ(any, expected_any);
}

// Two warps, the second of which is not full, and a ray that ends at once.
TEST(MultipassKernels, AnswersAreTheCpus) {
  const auto scene = make_builtin("soup:20");
  ASSERT_TRUE(scene.ok()) << scene.message();
  const auto set = random_rays({.lo = {-1, -1, -1}, .hi = {1, 1, 1}}, 33);
  std::vector<Ray> rays(set->rays.begin(), set->rays.end());
  rays[3].dir = {0, 0, 0};
  KernelMethods::for_each([&](auto tag) { expect_cpu_answers<typename decltype(tag)::type>(scene->mesh, rays); });
}

}  // namespace
}  // namespace accel
