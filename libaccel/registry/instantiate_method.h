// The definition of make_method_entry(): all executors for one method. Internal to the registry; only the sources that
// the build makes for each method include this.
#pragma once

#include <string>
#include <utility>

#include "libaccel/exec/cpu.h"
#include "libaccel/exec/multipass.h"
#include "libaccel/exec/simt.h"
#include "libaccel/registry/annotate.h"
#include "libaccel/registry/method_entry.h"

namespace accel {

namespace detail {

// Only for structures that the method's check has let pass.
template <class Method>
auto view_of(const AnyStructure& any) {
  const auto* structure = any.get_if<typename Method::Structure>();
  ACCEL_ASSERT(structure != nullptr);
  return structure->view();
}

template <class Method, class Test>
TestEntry make_test_entry() {
  using Closest = typename Method::template Traverser<Test, Query::closest>;
  using Any = typename Method::template Traverser<Test, Query::any>;
  TestEntry entry;
  entry.closest = [](const AnyStructure& s, std::span<const Ray> rays, std::span<Hit> hits, int threads) {
    trace_closest<Closest>(view_of<Method>(s), rays, hits, threads);
  };
  entry.occluded = [](const AnyStructure& s, std::span<const Ray> rays, std::span<std::uint8_t> occluded, int threads) {
    trace_any<Any>(view_of<Method>(s), rays, occluded, threads);
  };
  entry.closest_one = [](const AnyStructure& s, const Ray& ray) {
    NullObserver observer;
    return trace_ray<Closest>(view_of<Method>(s), ray, observer);
  };
  entry.occluded_one = [](const AnyStructure& s, const Ray& ray) {
    NullObserver observer;
    return trace_ray<Any>(view_of<Method>(s), ray, observer).valid();
  };
  entry.count = [](const AnyStructure& s, std::span<const Ray> rays, Query query, std::span<std::uint32_t> values, int threads,
                   RayCounter counter) {
    return query == Query::closest ? count_rays<Closest>(view_of<Method>(s), rays, values, threads, counter)
                                   : count_rays<Any>(view_of<Method>(s), rays, values, threads, counter);
  };
  entry.simt = [](const AnyStructure& s, std::span<const Ray> rays, Query query, std::span<Hit> hits,
                  const SimtOptions& options, int threads) {
    return query == Query::closest ? simulate_simt<Closest>(view_of<Method>(s), rays, hits, options, threads)
                                   : simulate_simt<Any>(view_of<Method>(s), rays, hits, options, threads);
  };
  entry.multipass = [](const AnyStructure& s, std::span<const Ray> rays, Query query, std::span<Hit> hits,
                       const MultipassOptions& options, int threads) {
    return query == Query::closest ? trace_multipass<Closest>(view_of<Method>(s), rays, hits, options, threads)
                                   : trace_multipass<Any>(view_of<Method>(s), rays, hits, options, threads);
  };
  return entry;
}

template <class Method>
Status check_structure(const AnyStructure& structure, const MethodInfo& info) {
  if (structure.get_if<typename Method::Structure>() == nullptr)
    return Error{"method " + info.name + " traces structures of kind '" + info.structure + "', and this is a '" +
                 std::string(structure.kind()) + "'"};
  using Traverser = typename Method::template Traverser<Watertight, Query::closest>;
  if constexpr (requires { Traverser::kMaxDepth; }) {
    if (structure.depth() > Traverser::kMaxDepth)
      return Error{"the structure is " + std::to_string(structure.depth()) + " levels deep, but " + info.name +
                   " has room for " + std::to_string(Traverser::kMaxDepth) + "; rebuild it with a smaller max_depth"};
  }
  return Done{};
}

// The structure's other holders keep it as it is: only the copy here gets the arrays, and shares all others with it.
template <class Method>
Status annotate_structure(AnyStructure& any, const MethodInfo& info, BuildReport& report) {
  using Traverser = typename Method::template Traverser<Watertight, Query::closest>;
  auto structure = *any.get_if<typename Method::Structure>();
  const bool changes = lacks_extras<Traverser>(structure);
  const Status status = annotate<Traverser>(structure, info.name, 0, report);
  if (status && changes) any = AnyStructure(std::move(structure));
  return status;
}

template <class Method>
Result<AnyAccel> build_method(const TriangleMesh& mesh, const MethodInfo& info, const BuildOptions& options) {
  auto built = build_for<Method>(mesh, options);
  if (!built) return built.error();
  return AnyAccel::bind(AnyStructure(std::move(built->structure)), info.name, std::move(built->report));
}

}  // namespace detail

template <class Method>
MethodEntry make_method_entry() {
  MethodEntry entry;
  entry.info = {Method::name(), Method::Builder::kName, Method::kTraverserName, Method::Structure::kName, Method::kExhaustive};
  entry.build = detail::build_method<Method>;
  entry.check = detail::check_structure<Method>;
  entry.annotate = detail::annotate_structure<Method>;
  std::size_t i = 0;
  TriangleTests::for_each(
      [&](auto test) { entry.tests[i++] = detail::make_test_entry<Method, typename decltype(test)::type>(); });
  return entry;
}

}  // namespace accel
