// The source of the CUDA kernel on the CPU's emulated warps, against the CPU executor. What a device does: see cuda_test.cpp.
#include <gtest/gtest.h>

#include <cstring>
#include <vector>

#include "libaccel/exec/cpu.h"
#include "libaccel/rays/ray_sets.h"
#include "libaccel/registry/annotate.h"
#include "scenes/procedural.h"
#include "validation/unit/exec/kernel_methods.h"
#include "validation/unit/exec/warp_emulator.h"
// The kernel needs the emulator's intrinsics.
#include "libaccel/exec/cuda/trace_kernel.cuh"

namespace accel {
namespace {

using cuda::GridWork;
using cuda::PersistentWork;
using cuda::StoreHits;
using cuda::StoreListed;
using cuda::StoreOccluded;

// Random rays, every seventh of which hits nothing by definition and ends at once.
std::vector<Ray> uneven_rays(std::size_t count) {
  const auto set = random_rays({.lo = {-1, -1, -1}, .hi = {1, 1, 1}}, count);
  std::vector<Ray> rays(set->rays.begin(), set->rays.end());
  for (std::size_t i = 3; i < rays.size(); i += 7) rays[i].dir = {0, 0, 0};
  return rays;
}

template <class Traverser, class Work, class Store>
void run_kernel(unsigned warps, const typename Traverser::View& view, const Ray* rays, const Work& work, const Store& store) {
  run_warps(warps, [&] { cuda::trace_kernel<Traverser, Work, Store>(view, rays, work, store); });
}

template <class Method>
void expect_cpu_answers(const typename Method::Structure::View& view, const std::vector<Ray>& rays) {
  using Closest = typename Method::template Traverser<Watertight, Query::closest>;
  using Any = typename Method::template Traverser<Watertight, Query::any>;
  SCOPED_TRACE(Method::name() + ", " + std::to_string(rays.size()) + " rays");
  const auto count = static_cast<std::uint32_t>(rays.size());
  std::vector<Hit> expected(count), hits(count);
  std::vector<std::uint8_t> expected_any(count), any(count, 2);
  trace_closest<Closest>(view, rays, expected, 1);
  trace_any<Any>(view, rays, expected_any, 1);
  const auto same_hits = [&] { return std::memcmp(hits.data(), expected.data(), count * sizeof(Hit)) == 0; };

  std::memset(static_cast<void*>(hits.data()), 0xab, count * sizeof(Hit));
  run_kernel<Closest>((count + 31) / 32, view, rays.data(), GridWork{count}, StoreHits{hits.data()});
  EXPECT_TRUE(same_hits());

  // Two warps compete for the rays, and each fetches again and again.
  std::uint32_t next_ray = 0;
  std::memset(static_cast<void*>(hits.data()), 0xab, count * sizeof(Hit));
  run_kernel<Closest>(2, view, rays.data(), PersistentWork{count, &next_ray}, StoreHits{hits.data()});
  EXPECT_TRUE(same_hits());
  EXPECT_GE(next_ray, count);

  // As a selection: the rays from the last to the first.
  std::vector<std::uint32_t> ids(count);
  for (std::uint32_t i = 0; i < count; ++i) ids[i] = count - 1 - i;
  const std::vector<Ray> selected(rays.rbegin(), rays.rend());
  std::memset(static_cast<void*>(hits.data()), 0xab, count * sizeof(Hit));
  run_kernel<Closest>((count + 31) / 32, view, selected.data(), GridWork{count},
                      StoreListed<StoreHits>{ids.data(), {hits.data()}});
  EXPECT_TRUE(same_hits());

  next_ray = 0;
  run_kernel<Any>(2, view, rays.data(), PersistentWork{count, &next_ray}, StoreOccluded{any.data()});
  EXPECT_EQ(any, expected_any);
}

TEST(TraceKernel, AnswersAreTheCpus) {
  const auto scene = make_builtin("soup:300");
  ASSERT_TRUE(scene.ok()) << scene.message();
  KernelMethods::for_each([&](auto tag) {
    using Method = typename decltype(tag)::type;
    const auto built = build_for<Method>(scene->mesh, {});
    ASSERT_TRUE(built.ok()) << built.message();
    for (const std::size_t count : {1, 33, 150}) expect_cpu_answers<Method>(built->structure.view(), uneven_rays(count));
  });
}

}  // namespace
}  // namespace accel
