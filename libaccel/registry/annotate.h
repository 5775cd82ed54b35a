// Arrays that only some traversers read: made when a structure is bound to a method that does, and never before.
//
// A structure with such arrays declares them, and the build layer has a function that adds them:
//
//   static constexpr Extras kExtras[] = {...};            // of an enumeration of its own
//   static constexpr const char* extras_name(Extras);     // a plural
//   bool has(Extras) const;
//   Status add_extras(Structure&, Extras, BuildReport&);  // may throw std::bad_alloc; may add notes to the report
//
// A traverser declares what it reads: `static constexpr Extras kNeeds = ...`, one of the structure's, or an array of several.
//
// Extras may exclude each other: adding one then takes another away (the links of structure/bvh2.h). A structure that is bound
// to a method gets what the method reads and may lose what it does not, in its own copies of the arrays that change: handles
// that share the structure with other methods keep theirs.
#pragma once

#include <algorithm>
#include <chrono>
#include <iterator>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include <tbb/task_arena.h>

#include "libaccel/build/builder.h"
#include "libaccel/build/bvh2_extras.h"
#include "libaccel/build/kdtree_extras.h"
#include "libaccel/build/two_level_extras.h"
#include "libaccel/core/hit.h"
#include "libaccel/core/threads.h"
#include "libaccel/geometry/instanced_meshes.h"
#include "libaccel/geometry/watertight.h"

namespace accel {

template <class Structure>
concept HasExtras = requires(const Structure& structure) {
  structure.has(Structure::kExtras[0]);
};

// Whether a traverser reads an optional array of its structure.
template <class Traverser, class Extras>
constexpr bool needs(Extras extras) {
  if constexpr (requires { std::begin(Traverser::kNeeds); })
    return std::find(std::begin(Traverser::kNeeds), std::end(Traverser::kNeeds), extras) != std::end(Traverser::kNeeds);
  else if constexpr (requires { Traverser::kNeeds; })
    return Traverser::kNeeds == extras;
  else
    return false;
}

// Whether the structure lacks something that the traverser reads.
template <class Traverser, class Structure>
bool lacks_extras(const Structure& structure) {
  if constexpr (HasExtras<Structure>)
    return std::any_of(std::begin(Structure::kExtras), std::end(Structure::kExtras),
                       [&](auto extras) { return needs<Traverser>(extras) && !structure.has(extras); });
  else
    return false;
}

namespace detail {

// Adds one, as a phase of the report.
template <class Structure, class Extras>
Status add_timed(Structure& structure, Extras extras, const std::string& method, BuildReport& report) {
  const std::string name = Structure::extras_name(extras);
  const auto start = std::chrono::steady_clock::now();
  try {
    if (const Status status = add_extras(structure, extras, report); !status) return status;
  } catch (const std::bad_alloc&) {
    return Error{"out of memory while adding " + name + " for " + method};
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  report.phases.push_back({name, seconds});
  report.seconds += seconds;
  report.peak_bytes = std::max<std::uint64_t>(report.peak_bytes, structure.size_bytes());
  report.notes.push_back({name, "added, because " + method + " reads them"});
  return Done{};
}

inline void forget_notes(BuildReport& report, const std::string& what) {
  std::erase_if(report.notes, [&](const BuildNote& note) { return note.what == what; });
}

}  // namespace detail

// Adds what `method`, whose traverser this is, reads and the structure lacks: each a phase and a note of the report. What it
// does not read is noted as skipped, unless it is there; so is what the traverser itself does without.
template <class Traverser, class Structure>
Status annotate(Structure& structure, const std::string& method, int threads, BuildReport& report) {
  if constexpr (HasExtras<Structure>) {
    tbb::task_arena arena(arena_size(threads));
    for (const auto extras : Structure::kExtras) {
      if (!needs<Traverser>(extras) || structure.has(extras)) continue;
      detail::forget_notes(report, Structure::extras_name(extras));
      const Status status = arena.execute([&] { return detail::add_timed(structure, extras, method, report); });
      if (!status) return status;
    }
    for (const auto extras : Structure::kExtras) {
      if (structure.has(extras)) continue;
      detail::forget_notes(report, Structure::extras_name(extras));  // another method's
      report.notes.push_back({Structure::extras_name(extras), "skipped, because " + method + " does not read them"});
    }
  }
  if constexpr (requires { Traverser::kSkips; }) {
    detail::forget_notes(report, Traverser::kSkips.what);
    report.notes.push_back({Traverser::kSkips.what, Traverser::kSkips.why});
  }
  return Done{};
}

// Builds from a mesh. A builder of instances gets one at its place.
template <class Method>
Result<Built<typename Method::Structure>> build_from(const TriangleMesh& mesh, const BuildOptions& options) {
  if constexpr (Method::kInstances) {
    const auto scene = InstancedMeshes::make({mesh}, {Instance{}});
    if (!scene) return scene.error();
    return Method::Builder::build(*scene, options);
  } else {
    return Method::Builder::build(mesh, options);
  }
}

// Builds from instances. A builder of meshes gets all their triangles.
template <class Method>
Result<Built<typename Method::Structure>> build_from(const InstancedMeshes& scene, const BuildOptions& options) {
  if constexpr (Method::kInstances) {
    return Method::Builder::build(scene, options);
  } else {
    const auto mesh = scene.flattened();
    if (!mesh) return mesh.error();
    auto built = Method::Builder::build(*mesh, options);
    if (built)
      built->report.notes.push_back({"instances", "flattened to one mesh of " + std::to_string(mesh->size()) +
                                                      " triangles, because " + Method::Builder::kName +
                                                      " builds over triangles; their vertices are rounded to floats"});
    return built;
  }
}

// Builds what a method of the registry traces from a mesh or from instances, extra arrays included.
template <class Method, class Scene>
Result<Built<typename Method::Structure>> build_for(const Scene& scene, const BuildOptions& options) {
  using Traverser = typename Method::template Traverser<Watertight, Query::closest>;
  auto built = build_from<Method>(scene, options);
  if (!built) return built;
  const Status status = annotate<Traverser>(built->structure, Method::name(), options.threads, built->report);
  if (!status) return status.error();
  return built;
}

}  // namespace accel
