// Arrays that only some traversers read: made when a structure is bound to a method that does, and never before.
//
// A structure with such arrays declares them, and the build layer has a function that adds them:
//
//   static constexpr Extras kExtras[] = {...};        // of an enumeration of its own
//   static constexpr const char* extras_name(Extras);
//   bool has(Extras) const;
//   void add_extras(Structure&, Extras);              // may throw std::bad_alloc
//
// A traverser declares what it reads: `static constexpr Extras kNeeds = ...`, one of the structure's.
#pragma once

#include <algorithm>
#include <chrono>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include <tbb/task_arena.h>

#include "libaccel/build/builder.h"
#include "libaccel/build/kdtree_extras.h"
#include "libaccel/core/hit.h"
#include "libaccel/core/threads.h"
#include "libaccel/geometry/watertight.h"

namespace accel {

template <class Structure>
concept HasExtras = requires(const Structure& structure) {
  structure.has(Structure::kExtras[0]);
};

// Whether a traverser reads an optional array of its structure.
template <class Traverser, class Extras>
constexpr bool needs(Extras extras) {
  if constexpr (requires { Traverser::kNeeds; })
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

// Adds what `method`, whose traverser this is, reads and the structure lacks: each a phase and a note of the report. What it
// does not read is noted as skipped, unless it is there; so is what the traverser itself does without.
template <class Traverser, class Structure>
Status annotate(Structure& structure, const std::string& method, int threads, BuildReport& report) {
  if constexpr (HasExtras<Structure>) {
    tbb::task_arena arena(arena_size(threads));
    for (const auto extras : Structure::kExtras) {
      const std::string name = Structure::extras_name(extras);
      if (structure.has(extras)) continue;
      std::erase_if(report.notes, [&](const BuildNote& note) { return note.what == name; });  // another method's
      if (!needs<Traverser>(extras)) {
        report.notes.push_back({name, "skipped, because " + method + " does not read them"});
        continue;
      }
      const auto start = std::chrono::steady_clock::now();
      try {
        arena.execute([&] { add_extras(structure, extras); });
      } catch (const std::bad_alloc&) {
        return Error{"out of memory while adding " + name + " for " + method};
      }
      const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      report.phases.push_back({name, seconds});
      report.seconds += seconds;
      report.peak_bytes = std::max<std::uint64_t>(report.peak_bytes, structure.size_bytes());
      report.notes.push_back({name, "added, because " + method + " reads them"});
    }
  }
  if constexpr (requires { Traverser::kSkips; }) {
    std::erase_if(report.notes, [](const BuildNote& note) { return note.what == Traverser::kSkips.what; });
    report.notes.push_back({Traverser::kSkips.what, Traverser::kSkips.why});
  }
  return Done{};
}

// Builds what a method of the registry traces, extra arrays included.
template <class Method>
Result<Built<typename Method::Structure>> build_for(const TriangleMesh& mesh, const BuildOptions& options) {
  using Traverser = typename Method::template Traverser<Watertight, Query::closest>;
  auto built = Method::Builder::build(mesh, options);
  if (!built) return built;
  const Status status = annotate<Traverser>(built->structure, Method::name(), options.threads, built->report);
  if (!status) return status.error();
  return built;
}

}  // namespace accel
