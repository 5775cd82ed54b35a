#include "libaccel/registry/any_accel.h"

#include <algorithm>
#include <array>
#include <limits>
#include <mutex>
#include <new>
#include <optional>
#include <utility>

#include "libaccel/core/out_of_memory.h"
#include "libaccel/core/suggest.h"
#include "libaccel/exec/count_rays.h"
#include "libaccel/exec/multipass.h"
#include "libaccel/exec/simt.h"
#include "libaccel/registry/method_entry.h"
#include "libaccel/registry/methods.h"

namespace accel {

namespace {

const std::vector<MethodEntry>& entries() {
  static const std::vector<MethodEntry> list = [] {
    std::vector<MethodEntry> result;
    Methods::for_each([&](auto method) { result.push_back(make_method_entry<typename decltype(method)::type>()); });
    return result;
  }();
  return list;
}

template <class Tests>
std::vector<std::string> names_of() {
  std::vector<std::string> names;
  Tests::for_each([&](auto test) { names.emplace_back(decltype(test)::type::kName); });
  return names;
}

Result<const MethodEntry*> find_entry(std::string_view name) {
  const Result<std::string> found = find_method(name);
  if (!found) return found.error();
  for (const MethodEntry& entry : entries())
    if (entry.info.name == *found) return &entry;
  return Error{"no method named '" + std::string(name) + "'"};
}

Result<std::size_t> find_test(std::string_view name) {
  if (name.empty()) return std::size_t{0};
  const std::vector<std::string>& names = triangle_tests();
  for (std::size_t i = 0; i < names.size(); ++i)
    if (names[i] == name) return i;
  return unknown_name("triangle test", name, std::vector<std::string_view>(names.begin(), names.end()));
}

template <class Out>
Status same_size(std::span<const Ray> rays, std::span<Out> out) {
  if (rays.size() == out.size()) return Done{};
  return Error{"there are " + std::to_string(rays.size()) + " rays, but room for " + std::to_string(out.size()) + " results"};
}

// Whether there is room for k hits a ray and a count.
Status has_room(std::span<const Ray> rays, std::size_t k, std::span<Hit> hits, std::span<std::uint32_t> counts) {
  if (k > std::numeric_limits<std::uint32_t>::max()) return Error{"there is no counting to " + std::to_string(k) + " hits"};
  if (Status s = same_size(rays, counts); !s) return s;
  if (k == 0 ? hits.empty() : hits.size() % k == 0 && hits.size() / k == rays.size()) return Done{};
  return Error{"there are " + std::to_string(rays.size()) + " rays with " + std::to_string(k) + " hits each, but room for " +
               std::to_string(hits.size()) + " hits"};
}

// A block has a ray at least.
BatchSettings batch_settings(const TraceOptions& options) {
  BatchSettings settings(options.threads, options.packets);
  settings.packets.block_size = std::max(settings.packets.block_size, 1u);
  return settings;
}

}  // namespace

const std::vector<MethodInfo>& methods() {
  static const std::vector<MethodInfo> list = [] {
    std::vector<MethodInfo> result;
    for (const MethodEntry& entry : entries()) result.push_back(entry.info);
    return result;
  }();
  return list;
}

const std::vector<std::string>& triangle_tests() {
  static const std::vector<std::string> list = names_of<TriangleTests>();
  return list;
}

const std::vector<std::string>& modelled_tests() {
  static const std::vector<std::string> list = names_of<ModelledTests>();
  return list;
}

namespace {

constexpr std::string_view kBest = "bvh8/stream", kBestOfInstances = "bvh8-instances/stream";

// The best of the methods that a condition lets pass: one of those two, or else the first; empty if there is none.
template <class Condition>
std::string best_of(const Condition& condition) {
  std::string first;
  for (const MethodInfo& m : methods()) {
    if (!condition(m)) continue;
    if (m.name == kBest || m.name == kBestOfInstances) return m.name;
    if (first.empty()) first = m.name;
  }
  return first;
}

}  // namespace

std::string best_method(const Purpose& purpose) {
  const std::string best = best_of([&](const MethodInfo& m) { return m.builder == purpose.builder; });
  return !best.empty() ? best : std::string(purpose.instances ? kBestOfInstances : kBest);
}

Result<std::string> find_method(std::string_view name) try {
  if (name == "best") return best_method();
  std::vector<std::string_view> names;
  for (const MethodInfo& info : methods()) {
    if (info.name == name) return info.name;
    names.push_back(info.name);
  }
  return unknown_name("method", name, names);
} catch (const std::bad_alloc&) {
  return out_of_memory("looking up a method");
}

// A triangle test as a method runs it, and the structure that it reads.
struct AnyAccel::Tracer {
  const TestEntry* entry;
  const AnyStructure* structure;
};

struct AnyAccel::State {
  State(AnyStructure s, BuildReport r, const MethodEntry& e)
      : structure(std::move(s)), report(std::move(r)), entry(&e), single_rays(e.single_rays(structure)) {}

  AnyStructure structure;
  BuildReport report;
  const MethodEntry* entry;
  SingleRays single_rays;

  // What tests read that precompute something, made when rays are first traced with them.
  struct Prepared {
    std::once_flag once;
    std::optional<AnyStructure> structure;
  };
  mutable std::array<Prepared, TriangleTests::size> prepared;

  // The structure for a test. May throw std::bad_alloc; the next call then tries again.
  const AnyStructure& structure_for(std::size_t test) const {
    const auto prepare = entry->tests[test].prepare;
    if (prepare == nullptr) return structure;
    Prepared& p = prepared[test];
    std::call_once(p.once, [&] { p.structure.emplace(prepare(structure)); });
    return *p.structure;
  }
};

Status AnyAccel::accepts(std::string_view test) const try {
  const auto found = find_test(test);
  if (!found) return found.error();
  if (state_->entry->tests[*found].closest != nullptr) return Done{};
  return Error{method().name + " does not trace with the test " + std::string(test) + ": the leaves of a '" +
               method().structure + "' have no room for what it precomputes"};
} catch (const std::bad_alloc&) {
  return out_of_memory("looking up a triangle test");
}

bool AnyAccel::is_tuned_for(std::string_view test) const {
  const auto found = find_test(test);
  return found && state_->entry->tests[*found].is_tuned;
}

Result<AnyAccel::Tracer> AnyAccel::tracer(std::string_view test) const try {
  if (const Status accepted = accepts(test); !accepted) return accepted.error();
  const std::size_t index = *find_test(test);
  return Tracer{&state_->entry->tests[index], &state_->structure_for(index)};
} catch (const std::bad_alloc&) {
  return out_of_memory("preparing a structure for a triangle test");
}

Result<AnyAccel::Tracer> AnyAccel::modelled_tracer(std::string_view test) const try {
  const auto found = tracer(test);
  if (!found || found->entry->next_hits != nullptr) return found;
  std::string names;
  for (const std::string& name : modelled_tests()) names += (names.empty() ? "" : " and ") + name;
  return Error{"models of machines and queries for several hits have the tests " + names + ", not " + std::string(test)};
} catch (const std::bad_alloc&) {
  return out_of_memory("looking up a triangle test");
}

Result<AnyAccel> AnyAccel::build(const TriangleMesh& mesh, std::string_view method, const BuildOptions& options) try {
  const auto entry = find_entry(method);
  if (!entry) return entry.error();
  const Status valid = validate(mesh);
  if (!valid) return valid.error();
  return (*entry)->build(mesh, (*entry)->info, options);
} catch (const std::bad_alloc&) {
  return out_of_memory("building a structure");
}

Result<AnyAccel> AnyAccel::build(const InstancedMeshes& scene, std::string_view method, const BuildOptions& options) try {
  const auto entry = find_entry(method == "best" ? best_method({.instances = scene.is_better_apart()}) : std::string(method));
  if (!entry) return entry.error();
  return (*entry)->build_instances(scene, (*entry)->info, options);
} catch (const std::bad_alloc&) {
  return out_of_memory("building a structure");
}

Result<AnyAccel> AnyAccel::bind(AnyStructure structure, std::string_view method, BuildReport report) try {
  const std::string name =
      method == "best" ? best_of([&](const MethodInfo& m) { return m.structure == structure.kind(); }) : std::string(method);
  const auto entry = find_entry(name);
  if (!entry) return entry.error();
  const Status fits = (*entry)->check(structure, (*entry)->info);
  if (!fits) return fits.error();
  const Status annotated = (*entry)->annotate(structure, (*entry)->info, report);
  if (!annotated) return annotated.error();
  return AnyAccel(std::make_shared<const State>(std::move(structure), std::move(report), **entry));
} catch (const std::bad_alloc&) {
  return out_of_memory("binding a structure to a method");
}

Result<AnyAccel> AnyAccel::with_method(std::string_view method) const try {
  return bind(structure(), method, report());
} catch (const std::bad_alloc&) {
  return out_of_memory("binding a structure to a method");
}

Status AnyAccel::closest(std::span<const Ray> rays, std::span<Hit> hits, const TraceOptions& options) const try {
  const auto test = tracer(options.test);
  if (!test) return test.error();
  if (Status s = same_size(rays, hits); !s) return s;
  test->entry->closest(*test->structure, rays, hits, batch_settings(options));
  return Done{};
} catch (const std::bad_alloc&) {
  return out_of_memory("tracing a batch; trace fewer rays at once, or on fewer threads");
}

Status AnyAccel::occluded(std::span<const Ray> rays, std::span<std::uint8_t> occluded, const TraceOptions& options) const try {
  const auto test = tracer(options.test);
  if (!test) return test.error();
  if (Status s = same_size(rays, occluded); !s) return s;
  test->entry->occluded(*test->structure, rays, occluded, batch_settings(options));
  return Done{};
} catch (const std::bad_alloc&) {
  return out_of_memory("tracing a batch; trace fewer rays at once, or on fewer threads");
}

Hit AnyAccel::closest(const Ray& ray) const { return state_->single_rays.closest(state_->single_rays.view.get(), ray); }
bool AnyAccel::occluded(const Ray& ray) const { return state_->single_rays.occluded(state_->single_rays.view.get(), ray); }

Status AnyAccel::k_nearest(std::span<const Ray> rays, std::size_t k, std::span<Hit> hits, std::span<std::uint32_t> counts,
                           const TraceOptions& options) const try {
  const auto test = modelled_tracer(options.test);
  if (!test) return test.error();
  if (Status s = has_room(rays, k, hits, counts); !s) return s;
  test->entry->next_hits(*test->structure, rays, {}, hits, counts, options.threads);
  return Done{};
} catch (const std::bad_alloc&) {
  return out_of_memory("tracing a batch; trace fewer rays at once, or on fewer threads");
}

Status AnyAccel::next_hits(std::span<const Ray> rays, std::span<const Hit> after, std::size_t k, std::span<Hit> hits,
                           std::span<std::uint32_t> counts, const TraceOptions& options) const try {
  const auto test = modelled_tracer(options.test);
  if (!test) return test.error();
  if (rays.size() != after.size())
    return Error{"there are " + std::to_string(rays.size()) + " rays, but " + std::to_string(after.size()) +
                 " hits to go on behind"};
  if (Status s = has_room(rays, k, hits, counts); !s) return s;
  test->entry->next_hits(*test->structure, rays, after, hits, counts, options.threads);
  return Done{};
} catch (const std::bad_alloc&) {
  return out_of_memory("tracing a batch; trace fewer rays at once, or on fewer threads");
}

std::size_t AnyAccel::k_nearest(const Ray& ray, std::span<Hit> hits) const {
  std::uint32_t count = 0;
  state_->entry->tests[0].next_hits(state_->structure, {&ray, 1}, {}, hits, {&count, 1}, 1);
  return count;
}

std::size_t AnyAccel::next_hits(const Ray& ray, const Hit& after, std::span<Hit> hits) const {
  std::uint32_t count = 0;
  state_->entry->tests[0].next_hits(state_->structure, {&ray, 1}, {&after, 1}, hits, {&count, 1}, 1);
  return count;
}

Result<Counters> AnyAccel::count(std::span<const Ray> rays, Query query, std::span<std::uint32_t> values,
                                 const TraceOptions& options, RayCounter counter) const try {
  const auto test = tracer(options.test);
  if (!test) return test.error();
  if (!values.empty())
    if (Status s = same_size(rays, values); !s) return s.error();
  return count_rays(test->entry->traverser(*test->structure, query, Machine::cpu), rays, values, options.threads, counter);
} catch (const std::bad_alloc&) {
  return out_of_memory("counting what rays cost");
}

Result<SimtProfile> AnyAccel::profile_simt(std::span<const Ray> rays, Query query, std::span<Hit> hits, const SimtOptions& simt,
                                           const TraceOptions& options) const try {
  const auto test = modelled_tracer(options.test);
  if (!test) return test.error();
  if (!hits.empty())
    if (Status s = same_size(rays, hits); !s) return s.error();
  // Models of machines are models of devices.
  return simulate_simt(test->entry->traverser(*test->structure, query, Machine::device), rays, hits, simt, options.threads);
} catch (const std::bad_alloc&) {
  return out_of_memory("tracing on the warp model");
}

Result<MultipassProfile> AnyAccel::trace_multipass(std::span<const Ray> rays, Query query, std::span<Hit> hits,
                                                   const MultipassOptions& multipass, const TraceOptions& options) const try {
  const auto test = modelled_tracer(options.test);
  if (!test) return test.error();
  if (!hits.empty())
    if (Status s = same_size(rays, hits); !s) return s.error();
  const AnyTraverser::View traverser = test->entry->traverser(*test->structure, query, Machine::device);
  return accel::trace_multipass(traverser, rays, hits, multipass, options.threads);
} catch (const std::bad_alloc&) {
  return out_of_memory("tracing in several passes");
}

const MethodInfo& AnyAccel::method() const { return state_->entry->info; }
const AnyStructure& AnyAccel::structure() const { return state_->structure; }
const BuildReport& AnyAccel::report() const { return state_->report; }
std::size_t AnyAccel::size_bytes() const { return state_->structure.size_bytes(); }

}  // namespace accel
