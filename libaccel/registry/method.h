// What a method is, and the triangle tests that every method is compiled for.
#pragma once

#include <string>

#include "libaccel/build/builder.h"
#include "libaccel/core/hit.h"
#include "libaccel/core/type_list.h"
#include "libaccel/geometry/instanced_meshes.h"
#include "libaccel/geometry/moeller_trumbore.h"
#include "libaccel/geometry/watertight.h"

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
  // Whether the structure keeps instances apart; other methods trace their triangles as one mesh.
  static constexpr bool kInstances = requires(const InstancedMeshes& scene, const BuildOptions& options) {
    Builder::build(scene, options);
  };
  static std::string name() { return std::string(Builder::kName) + "/" + kTraverserName; }
};

// The first is the default.
using TriangleTests = TypeList<Watertight, MoellerTrumbore>;

}  // namespace accel
