// What a method is, and the triangle tests that every method is compiled for.
#pragma once

#include <string>

#include "libaccel/build/builder.h"
#include "libaccel/core/hit.h"
#include "libaccel/core/type_list.h"
#include "libaccel/geometry/baldwin_weber.h"
#include "libaccel/geometry/instanced_meshes.h"
#include "libaccel/geometry/moeller_trumbore.h"
#include "libaccel/geometry/pluecker.h"
#include "libaccel/geometry/watertight.h"
#include "libaccel/geometry/woop.h"
#include "libaccel/structure/transform_triangles.h"

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
  static constexpr bool kIsRobust = [] {
    if constexpr (requires { Traverser<Watertight, Query::closest>::kIsRobust; })
      return Traverser<Watertight, Query::closest>::kIsRobust;
    else
      return true;
  }();
  // Whether the structure keeps instances apart; other methods trace their triangles as one mesh.
  static constexpr bool kInstances = requires(const InstancedMeshes& scene, const BuildOptions& options) {
    Builder::build(scene, options);
  };
  static std::string name() { return std::string(Builder::kName) + "/" + kTraverserName; }
};

// The first is the default, and the only one whose hits all of the library promises.
using TriangleTests = TypeList<Watertight, MoellerTrumbore, Woop, WoopKahan, Pluecker, BaldwinWeber>;

// Those that models of machines, multi-hit queries and devices are compiled for, too; the others are compared by their speed
// and errors on CPUs. The first of the above.
using ModelledTests = TypeList<Watertight, MoellerTrumbore>;

template <class Test>
inline constexpr bool kIsModelled = ModelledTests::index_of<Test>() < ModelledTests::size;

// A test that reads something else than vertices: see structure/transform_triangles.h.
template <class Test>
concept PrecomputedTest = requires(const PackedTriangle& triangle) {
  Test::prepare_triangle(triangle);
};


}  // namespace accel
