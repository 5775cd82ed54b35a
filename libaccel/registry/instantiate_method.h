// The definition of make_method_entry(): all executors for one method. Internal to the registry; only the sources that
// the build makes for each method include this.
#pragma once

#include <concepts>
#include <string>
#include <type_traits>
#include <utility>

#include "libaccel/exec/any_traverser.h"
#include "libaccel/exec/cpu.h"
#include "libaccel/exec/multi_hit.h"
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

// run(view, std::type_identity<T>{}) with the method's traverser that serves the structure best on a machine.
template <class Method, class Traverser, Machine kMachine, class Run>
auto run_on(const AnyStructure& structure, const Run& run) {
  const auto view = view_of<Method>(structure);
  return with_traverser<Traverser, kMachine>(view, [&](auto traverser) { return run(view, traverser); });
}

template <class Structure>
concept HasBvh2Extras = requires {
  requires std::same_as<std::remove_cvref_t<decltype(Structure::kExtras[0])>, Bvh2Extras>;
};

// Whether the method's structure has room for what the test reads: not where the words of triangles are links to uncles.
template <class Method, class Test>
constexpr bool can_hold() {
  using Traverser = typename Method::template Traverser<Test, Query::closest>;
  using Structure = typename Method::Structure;
  bool has_room = !PrecomputedTest<Test> || HoldsPackedTriangles<Structure>;
  if constexpr (PrecomputedTest<Test> && HasBvh2Extras<Structure>)
    for (const Bvh2Extras links : {Bvh2Extras::uncles, Bvh2Extras::hash, Bvh2Extras::full_hash})
      has_room = has_room && !needs<Traverser>(links);
  return has_room;
}

template <class Method, class Test>
struct TestFunctions {
  using Closest = typename Method::template Traverser<Test, Query::closest>;
  using Any = typename Method::template Traverser<Test, Query::any>;

  static AnyStructure prepare(const AnyStructure& s) {
    const auto& structure = *s.get_if<typename Method::Structure>();
    return with_transformed_triangles(structure, [](const PackedTriangle& t) { return Test::prepare_triangle(t); });
  }
  static void closest(const AnyStructure& s, std::span<const Ray> rays, std::span<Hit> hits, const BatchSettings& settings) {
    run_on<Method, Closest, Machine::cpu>(
        s, [&]<class T>(const auto& view, std::type_identity<T>) { trace_closest<T>(view, rays, hits, settings); });
  }
  static void occluded(const AnyStructure& s, std::span<const Ray> rays, std::span<std::uint8_t> occluded,
                       const BatchSettings& settings) {
    run_on<Method, Any, Machine::cpu>(
        s, [&]<class T>(const auto& view, std::type_identity<T>) { trace_any<T>(view, rays, occluded, settings); });
  }
  template <Machine kMachine>
  static AnyTraverser::View traverser_on(const AnyStructure& s, Query query) {
    const auto any = []<class T>(const auto& view, std::type_identity<T>) { return any_view<T>(view); };
    return query == Query::closest ? run_on<Method, Closest, kMachine>(s, any) : run_on<Method, Any, kMachine>(s, any);
  }
  static AnyTraverser::View traverser(const AnyStructure& s, Query query, Machine machine) {
    if constexpr (kIsModelled<Test>)
      if (machine == Machine::device) return traverser_on<Machine::device>(s, query);
    ACCEL_ASSERT(machine == Machine::cpu);
    return traverser_on<Machine::cpu>(s, query);
  }
  // By the traverser that serves all structures: special ones gain little here, and each would be compiled once more.
  static void next_hits(const AnyStructure& s, std::span<const Ray> rays, std::span<const Hit> after, std::span<Hit> hits,
                        std::span<std::uint32_t> counts, int threads) {
    using Traverser = typename Method::template Traverser<Collect<Test>, Query::closest>;
    trace_hits<Traverser>(view_of<Method>(s), rays, after, hits, counts, threads);
  }

  static constexpr TestEntry entry() {
    TestEntry entry{};
    if constexpr (can_hold<Method, Test>()) {
      entry.is_tuned = is_tuned<Closest>();
      if constexpr (PrecomputedTest<Test>) entry.prepare = prepare;
      entry.closest = closest, entry.occluded = occluded, entry.traverser = traverser;
      if constexpr (kIsModelled<Test>) entry.next_hits = next_hits;
    }
    return entry;
  }
};

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

template <class Traverser>
Hit closest_of(const void* view, const Ray& ray) {
  Hit hit;
  trace_one<Traverser>(*static_cast<const typename Traverser::View*>(view), ray, hit);
  return hit;
}
template <class Traverser>
bool is_occluded(const void* view, const Ray& ray) {
  std::uint8_t occluded = 0;
  trace_one<Traverser>(*static_cast<const typename Traverser::View*>(view), ray, occluded);
  return occluded != 0;
}

template <class Method>
SingleRays single_rays(const AnyStructure& structure) {
  using Functions = TestFunctions<Method, Watertight>;
  auto view = view_of<Method>(structure);
  return {std::make_shared<decltype(view)>(view),
          run_on<Method, typename Functions::Closest, Machine::cpu>(
              structure, []<class T>(const auto&, std::type_identity<T>) { return &closest_of<T>; }),
          run_on<Method, typename Functions::Any, Machine::cpu>(
              structure, []<class T>(const auto&, std::type_identity<T>) { return &is_occluded<T>; })};
}

template <class Method, class Scene>
Result<AnyAccel> build_method(const Scene& scene, const MethodInfo& info, const BuildOptions& options) {
  auto built = build_for<Method>(scene, options);
  if (!built) return built.error();
  return AnyAccel::bind(AnyStructure(std::move(built->structure)), info.name, std::move(built->report));
}

}  // namespace detail

template <class Method>
MethodEntry make_method_entry() {
  MethodEntry entry;
  entry.info = {Method::name(),      Method::Builder::kName, Method::kTraverserName, Method::Structure::kName,
                Method::kExhaustive, Method::kInstances,     Method::kIsRobust};
  entry.build = detail::build_method<Method, TriangleMesh>;
  entry.build_instances = detail::build_method<Method, InstancedMeshes>;
  entry.check = detail::check_structure<Method>;
  entry.annotate = detail::annotate_structure<Method>;
  entry.single_rays = detail::single_rays<Method>;
  std::size_t i = 0;
  TriangleTests::for_each(
      [&](auto test) { entry.tests[i++] = detail::TestFunctions<Method, typename decltype(test)::type>::entry(); });
  return entry;
}

}  // namespace accel
