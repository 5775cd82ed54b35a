// The source of the multipass kernels on the CPU's emulated warps, against the CPU executor. What a device does: see
// cuda_test.cpp.
#include <gtest/gtest.h>

#include <cstring>
#include <vector>

#include "libaccel/exec/cpu.h"
#include "libaccel/exec/multipass_schedule.h"
#include "libaccel/rays/ray_sets.h"
#include "libaccel/registry/any_accel.h"
#include "libaccel/registry/methods.h"
#include "scenes/procedural.h"
#include "validation/unit/exec/warp_emulator.h"
// The kernels need the emulator's intrinsics.
#include "libaccel/exec/cuda/multipass_kernel.cuh"

namespace accel {
namespace {

using cuda::KeepHits;
using cuda::MultipassLists;
using cuda::MultipassStreams;
using cuda::StoreOccluded;
using Kernel = MultipassKernel;

// Rays in lists of our own, as exec/cuda/launch_multipass.cuh has them on the device.
template <class Traverser, class Finish>
class EmulatedRun {
 public:
  EmulatedRun(const typename Traverser::View& view, const std::vector<Ray>& rays, std::vector<Hit>& hits, const Finish& finish)
      : view_(view), finish_(finish), states_(rays.size()), stacks_(rays.size()), phases_(rays.size()) {
    streams_ = {rays.data(), hits.data(), states_.data(), stacks_.data(), phases_.data()};
    lists_.sizes = sizes_;
    for (int k = 0; k < kMultipassKernels; ++k) {
      storage_[k].resize(rays.size());
      lists_.rays[k] = storage_[k].data();
    }
    storage_[kMultipassKernels].resize(rays.size());
    spare_ = storage_[kMultipassKernels].data();
  }

  void run(MultipassRule rule) {
    const auto count = static_cast<std::uint32_t>(states_.size());
    const auto pass = [this](Kernel kernel, MultipassCounts& waiting) -> Status {
      const auto k = static_cast<std::size_t>(kernel);
      const std::uint32_t* list = kernel == Kernel::initialize ? nullptr : lists_.rays[k];
      std::swap(lists_.rays[k], spare_);
      sizes_[k] = 0;
      launch(kernel, list, waiting[kernel]);
      for (int i = 0; i < kMultipassKernels; ++i) waiting[static_cast<Kernel>(i)] = sizes_[i];
      return Done{};
    };
    EXPECT_TRUE(run_passes(rule, count, pass).ok());
  }

 private:
  void launch(Kernel kernel, const std::uint32_t* list, std::uint32_t count) {
    switch (kernel) {
      case Kernel::initialize:
        return launch_kernel<Kernel::initialize>(list, count);
      case Kernel::down:
        return launch_kernel<Kernel::down>(list, count);
      case Kernel::leaf:
        return launch_kernel<Kernel::leaf>(list, count);
      case Kernel::intersect:
        return launch_kernel<Kernel::intersect>(list, count);
      case Kernel::continue_search:
        return launch_kernel<Kernel::continue_search>(list, count);
      case Kernel::up:
        return launch_kernel<Kernel::up>(list, count);
      case Kernel::finished:
        return;
    }
  }

  template <Kernel kKernel>
  void launch_kernel(const std::uint32_t* list, std::uint32_t count) {
    run_warps((count + 31) / 32,
              [&] { cuda::multipass_kernel<Traverser, kKernel, Finish>(view_, streams_, list, count, lists_, finish_); });
  }

  const typename Traverser::View& view_;
  const Finish finish_;
  std::vector<typename Traverser::State> states_;
  std::vector<StackOf<Traverser>> stacks_;
  std::vector<Phase> phases_;
  MultipassStreams<Traverser> streams_;
  std::vector<std::uint32_t> storage_[kMultipassKernels + 1];
  std::uint32_t sizes_[kMultipassKernels] = {};
  MultipassLists lists_;
  std::uint32_t* spare_ = nullptr;
};

template <class Method>
void expect_cpu_answers(const typename Method::Structure::View& view, const std::vector<Ray>& rays, MultipassRule rule) {
  using Closest = typename Method::template Traverser<Watertight, Query::closest>;
  using Any = typename Method::template Traverser<Watertight, Query::any>;
  SCOPED_TRACE(Method::name() + " " + rule_name(rule));
  const std::size_t count = rays.size();
  std::vector<Hit> expected(count), hits(count);
  std::vector<std::uint8_t> expected_any(count), any(count, 2);
  trace_closest<Closest>(view, rays, expected, 1);
  trace_any<Any>(view, rays, expected_any, 1);

  std::memset(static_cast<void*>(hits.data()), 0xab, count * sizeof(Hit));
  EmulatedRun<Closest, KeepHits>(view, rays, hits, KeepHits{}).run(rule);
  EXPECT_EQ(std::memcmp(hits.data(), expected.data(), count * sizeof(Hit)), 0);
  EmulatedRun<Any, StoreOccluded>(view, rays, hits, StoreOccluded{any.data()}).run(rule);
  EXPECT_EQ(any, expected_any);
}

// Two warps, the second of which is not full, and a ray that ends at once.
TEST(MultipassKernels, AnswersAreTheCpusForEveryMethod) {
  const auto scene = make_builtin("soup:40");
  ASSERT_TRUE(scene.ok()) << scene.message();
  const auto set = random_rays({.lo = {-1, -1, -1}, .hi = {1, 1, 1}}, 33);
  std::vector<Ray> rays(set->rays.begin(), set->rays.end());
  rays[3].dir = {0, 0, 0};
  Methods::for_each([&](auto tag) {
    using Method = typename decltype(tag)::type;
    const auto accel = AnyAccel::build(scene->mesh, Method::name());
    ASSERT_TRUE(accel.ok()) << accel.message();
    const auto* structure = accel->structure().template get_if<typename Method::Structure>();
    expect_cpu_answers<Method>(structure->view(), rays, MultipassRule::delany);
  });
}

}  // namespace
}  // namespace accel
