// A line of the registry as a value: its description, and what it can do, behind function pointers.
//
// Internal to the registry. The value of each method is made in an object file of its own, whose source the build makes from
// the list (cmake/AccelMethods.cmake): its instantiations for all tests, queries and executors are most of what there is to
// compile.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "libaccel/exec/any_traverser.h"
#include "libaccel/exec/batch_settings.h"
#include "libaccel/registry/any_accel.h"
#include "libaccel/registry/method.h"

namespace accel {

// What a method can do with a structure, for one triangle test. One function pointer a query: no virtual calls inside. All are
// null where the structure cannot hold what the test reads, and the last for tests that are not modelled (registry/method.h).
struct TestEntry {
  bool is_tuned;  // see exec/batch_traverser.h

  // Makes the structure that the others take from one of vertices; null: the same.
  AnyStructure (*prepare)(const AnyStructure&);
  void (*closest)(const AnyStructure&, std::span<const Ray>, std::span<Hit>, const BatchSettings&);
  void (*occluded)(const AnyStructure&, std::span<const Ray>, std::span<std::uint8_t>, const BatchSettings&);
  // The traverser for what counts and models: the one that serves the structure best on the machine. Devices: if modelled.
  AnyTraverser::View (*traverser)(const AnyStructure&, Query, Machine);
  // The nearest hits behind after[i]: see exec/multi_hit.h.
  void (*next_hits)(const AnyStructure&, std::span<const Ray>, std::span<const Hit> after, std::span<Hit>,
                    std::span<std::uint32_t> counts, int threads);
};

// What traces single rays, with the default test: functions of the view that they come with.
struct SingleRays {
  std::shared_ptr<const void> view;
  Hit (*closest)(const void* view, const Ray&);
  bool (*occluded)(const void* view, const Ray&);
};

struct MethodEntry {
  MethodInfo info;
  Result<AnyAccel> (*build)(const TriangleMesh&, const MethodInfo&, const BuildOptions&);
  Result<AnyAccel> (*build_instances)(const InstancedMeshes&, const MethodInfo&, const BuildOptions&);
  Status (*check)(const AnyStructure&, const MethodInfo&);             // may the traverser trace this structure?
  Status (*annotate)(AnyStructure&, const MethodInfo&, BuildReport&);  // adds what the traverser reads and the structure lacks
  SingleRays (*single_rays)(const AnyStructure&);                      // may throw std::bad_alloc
  std::array<TestEntry, TriangleTests::size> tests;
};

// The entry of a line of registry/methods.h. Defined in registry/instantiate_method.h.
template <class Method>
MethodEntry make_method_entry();

}  // namespace accel
