// The one list of methods, and of triangle tests.
//
// To add a traverser: write one header in trace/, include it and add one line here. The command lines, the conformance and
// differential tests, the benchmarks, the SIMT model and the CUDA kernels all iterate over these lists. The build reads this
// file too: it makes one object file a method, so each stands on a line of its own (cmake/AccelMethods.cmake).
#pragma once

#include <string>

#include "libaccel/build/binned_sah.h"
#include "libaccel/build/sbvh.h"
#include "libaccel/build/triangle_list.h"
#include "libaccel/core/type_list.h"
#include "libaccel/geometry/moeller_trumbore.h"
#include "libaccel/geometry/watertight.h"
#include "libaccel/trace/brute_force.h"
#include "libaccel/trace/bvh2_stack.h"

namespace accel {

// A builder (build/builder.h) and a traverser (trace/traverser.h) of the structure that it makes.
template <class BuilderType, template <class, Query> class TraverserTemplate>
struct Method {
  using Builder = BuilderType;
  using Structure = typename Builder::Structure;
  template <class Test, Query kQuery>
  using Traverser = TraverserTemplate<Test, kQuery>;

  static constexpr const char* kTraverserName = Traverser<Watertight, Query::closest>::kName;
  static constexpr bool kExhaustive = requires { requires Traverser<Watertight, Query::closest>::kIsExhaustive; };
  static std::string name() { return std::string(Builder::kName) + "/" + kTraverserName; }
};

using Methods = TypeList<             //
    Method<ListBuilder, BruteForce>,  // brute/loop
    Method<BinnedSah, Bvh2Stack>,     // bvh/stack
    Method<Sbvh, Bvh2Stack>           // sbvh/stack
    >;

// The first is the default.
using TriangleTests = TypeList<Watertight, MoellerTrumbore>;

}  // namespace accel
