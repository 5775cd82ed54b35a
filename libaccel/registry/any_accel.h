// AnyAccel: a structure and the method that traces it, with their types erased. What programs use.
//
// Batches cost one indirect call; single rays cost one each. Handles share their structure: copying one is cheap, and moving is
// copying, so that none is ever empty. (Who needs an empty one has std::optional<AnyAccel>.) All const functions may be called
// from several threads at once.
//
// Scenes are read while a structure is built, and never again: they may change or go. Hits name triangles; who wants a normal
// keeps the mesh.
//
// Threads that flush denormals to zero, as Embree asks of its users, get the same hits where coordinates are above 1e-25 or so;
// below, rays may be lost, and hits depend on which threads have that mode.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "libaccel/build/builder.h"
#include "libaccel/core/hit.h"
#include "libaccel/core/ray.h"
#include "libaccel/exec/counters.h"
#include "libaccel/exec/multipass_profile.h"
#include "libaccel/exec/simt_profile.h"
#include "libaccel/geometry/instanced_meshes.h"
#include "libaccel/packet/packet_options.h"
#include "libaccel/registry/any_structure.h"

namespace accel {

// A line of the registry.
struct MethodInfo {
  std::string name;       // "sbvh/stack"
  std::string builder;    // "sbvh"
  std::string traverser;  // "stack"
  std::string structure;  // "bvh2"
  bool exhaustive;        // every ray tests every triangle: see trace/traverser.h
  bool instances;         // keeps instances apart: see registry/method.h
  bool robust;            // loses no hit with the first triangle test; others are there to be compared
};

// All methods and all triangle tests, in the registry's order; and the tests that models of machines, queries for several hits
// and devices have.
const std::vector<MethodInfo>& methods();
const std::vector<std::string>& triangle_tests();
const std::vector<std::string>& modelled_tests();

// The name of a method, or an error that suggests one. "best" is best_method().
Result<std::string> find_method(std::string_view name);

// What a method is to serve.
struct Purpose {
  std::string_view builder = {};  // who made the structure; empty, or the name of no builder: it is still to be built
  Query query = Query::closest;
  bool instances = false;  // the scene is one of instances that are to be kept apart
};

// The method that the library recommends on this machine. For a builder's structure it is one of the builder's methods.
std::string best_method(const Purpose& purpose = {});

struct TraceOptions {
  int threads = 0;        // 0: as many as the machine has; 1: the calling thread alone
  std::string_view test;  // a name of triangle_tests(); empty: the first
  PacketOptions packets;  // for methods that trace batches as packets; hits do not depend on them
};

class AnyAccel {
 public:
  AnyAccel(const AnyAccel&) = default;
  AnyAccel& operator=(const AnyAccel&) = default;

  // Builds what `method` needs from a mesh that validate() accepts. "best" is the method that the library recommends: for the
  // scene here, for structures of the kind in bind() and with_method().
  static Result<AnyAccel> build(const TriangleMesh& mesh, std::string_view method, const BuildOptions& options = {});

  // The same for a scene of instances, whose meshes nobody has changed. Methods that do not keep them apart trace their
  // triangles as one mesh, which the scene makes once and keeps, and the report says so; the prim_ids are the same.
  static Result<AnyAccel> build(const InstancedMeshes& scene, std::string_view method, const BuildOptions& options = {});

  // Binds a structure that exists, from a file say, to a method that traces structures of its kind. `report` tells how it was
  // built. Optional arrays that the method reads and the structure lacks are made, on all threads, and reported. See
  // registry/accel_files.h for files.
  static Result<AnyAccel> bind(AnyStructure structure, std::string_view method, BuildReport report = {});

  // Whether rays can be traced with a test of triangle_tests(): not with one that reads transforms where leaves have no room
  // for them. The first rays that are traced with such a test wait for the transforms of all triangles, a copy of the leaves.
  Status accepts(std::string_view test) const;

  // Whether the method's code for batches is written for the test, and not one that serves any. False for unknown tests.
  bool is_tuned_for(std::string_view test) const;

  // Fails if the traverser cannot trace this structure: wrong kind, or too deep for its stack.
  Result<AnyAccel> with_method(std::string_view method) const;

  // hits[i] answers rays[i], and occluded[i] is 1 or 0; the spans have the same size. An error for a test that accepts()
  // refuses.
  Status closest(std::span<const Ray> rays, std::span<Hit> hits, const TraceOptions& options = {}) const;
  Status occluded(std::span<const Ray> rays, std::span<std::uint8_t> occluded, const TraceOptions& options = {}) const;

  // Single rays, with the watertight test.
  Hit closest(const Ray& ray) const;
  bool occluded(const Ray& ray) const;

  // The k nearest hits of each ray, in order: by t, and by prim_id where t is the same; every triangle comes once. hits is an
  // array of rays x k: hits[i * k + j] is number j of rays[i], counts[i] says how many there are, and the rest of the k are
  // misses. One traversal a ray, which culls behind the k-th hit so far. See registry/multi_hit.h for all hits of a ray. This,
  // next_hits() and the models of machines exist for modelled_tests() alone.
  Status k_nearest(std::span<const Ray> rays, std::size_t k, std::span<Hit> hits, std::span<std::uint32_t> counts,
                   const TraceOptions& options = {}) const;

  // The same from where another query has stopped: only hits behind after[i] in that order. Behind a miss there is nothing.
  // A hit and its ray are all that resuming takes, with any method.
  Status next_hits(std::span<const Ray> rays, std::span<const Hit> after, std::size_t k, std::span<Hit> hits,
                   std::span<std::uint32_t> counts, const TraceOptions& options = {}) const;

  // Single rays, with the watertight test: k is the size of `hits`, and the number of hits is returned.
  std::size_t k_nearest(const Ray& ray, std::span<Hit> hits) const;
  std::size_t next_hits(const Ray& ray, const Hit& after, std::span<Hit> hits) const;

  // What the rays cost. values, unless empty, gets one number a ray: what `counter` says.
  Result<Counters> count(std::span<const Ray> rays, Query query, std::span<std::uint32_t> values = {},
                         const TraceOptions& options = {}, RayCounter counter = RayCounter::steps) const;

  // What the rays would cost on a machine with 32-wide warps: see exec/simt.h. hits[i] answers rays[i], as closest() does, and
  // tells no more than valid() or not for any-hit queries; an empty span if the profile is all that is wanted.
  Result<SimtProfile> profile_simt(std::span<const Ray> rays, Query query, std::span<Hit> hits = {},
                                   const SimtOptions& simt = {}, const TraceOptions& options = {}) const;

  // The same rays as streams through small kernels: see exec/multipass.h. The hits are as those of profile_simt().
  Result<MultipassProfile> trace_multipass(std::span<const Ray> rays, Query query, std::span<Hit> hits = {},
                                           const MultipassOptions& multipass = {}, const TraceOptions& options = {}) const;

  const MethodInfo& method() const;
  const AnyStructure& structure() const;
  const BuildReport& report() const;
  std::size_t size_bytes() const;

 private:
  struct State;
  struct Tracer;
  // The method with a test; for what only modelled tests have.
  Result<Tracer> tracer(std::string_view test) const;
  Result<Tracer> modelled_tracer(std::string_view test) const;

  explicit AnyAccel(std::shared_ptr<const State> state) : state_(std::move(state)) {}
  std::shared_ptr<const State> state_;
};

}  // namespace accel
