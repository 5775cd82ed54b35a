#include "libaccel/registry/any_accel.h"

#include <array>

#include "libaccel/core/suggest.h"
#include "libaccel/exec/cpu.h"
#include "libaccel/exec/simt.h"

namespace accel {

namespace {

// What a method can do with a structure, for one triangle test. One function pointer a query: no virtual calls inside.
struct TestEntry {
  void (*closest)(const AnyStructure&, std::span<const Ray>, std::span<Hit>, int threads);
  void (*occluded)(const AnyStructure&, std::span<const Ray>, std::span<std::uint8_t>, int threads);
  Hit (*closest_one)(const AnyStructure&, const Ray&);
  bool (*occluded_one)(const AnyStructure&, const Ray&);
  Counters (*count)(const AnyStructure&, std::span<const Ray>, Query, std::span<std::uint32_t> steps, int threads);
  SimtProfile (*simt)(const AnyStructure&, std::span<const Ray>, Query, const SimtOptions&, int threads);
};

struct MethodEntry {
  MethodInfo info;
  Result<AnyAccel> (*build)(const TriangleMesh&, const MethodInfo&, const BuildOptions&);
  Status (*check)(const AnyStructure&, const MethodInfo&);  // may the traverser trace this structure?
  std::array<TestEntry, TriangleTests::size> tests;
};

template <class Method>
auto view_of(const AnyStructure& structure) {
  return std::get<typename Method::Structure>(structure).view();
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
  entry.count = [](const AnyStructure& s, std::span<const Ray> rays, Query query, std::span<std::uint32_t> steps, int threads) {
    return query == Query::closest ? count_rays<Closest>(view_of<Method>(s), rays, steps, threads)
                                   : count_rays<Any>(view_of<Method>(s), rays, steps, threads);
  };
  entry.simt = [](const AnyStructure& s, std::span<const Ray> rays, Query query, const SimtOptions& options, int threads) {
    return query == Query::closest ? simulate_simt<Closest>(view_of<Method>(s), rays, {}, options, threads)
                                   : simulate_simt<Any>(view_of<Method>(s), rays, {}, options, threads);
  };
  return entry;
}

// The depth of a structure that has one.
template <class Structure>
std::uint32_t depth_of(const Structure& structure) {
  if constexpr (requires { structure.depth; }) return structure.depth;
  else return 0;
}

template <class Method>
Status check_structure(const AnyStructure& any, const MethodInfo& info) {
  const auto* structure = std::get_if<typename Method::Structure>(&any);
  if (structure == nullptr)
    return Error{"method " + info.name + " traces structures of kind '" + info.structure + "', and this is a '" +
                 std::visit([](const auto& s) { return std::string(s.kName); }, any) + "'"};
  using Traverser = typename Method::template Traverser<Watertight, Query::closest>;
  if constexpr (requires { Traverser::kMaxDepth; }) {
    if (depth_of(*structure) > Traverser::kMaxDepth)
      return Error{"the structure is " + std::to_string(depth_of(*structure)) + " levels deep, but " + info.name +
                   " has room for " + std::to_string(Traverser::kMaxDepth) + "; rebuild it with a smaller max_depth"};
  }
  return Done{};
}

template <class Method>
Result<AnyAccel> build_method(const TriangleMesh& mesh, const MethodInfo& info, const BuildOptions& options) {
  auto built = Method::Builder::build(mesh, options);
  if (!built) return built.error();
  return AnyAccel::bind(AnyStructure(std::move(built->structure)), info.name, std::move(built->report));
}

template <class Method>
MethodEntry make_entry() {
  MethodEntry entry;
  entry.info = {Method::name(), Method::Builder::kName, Method::kTraverserName, Method::Structure::kName};
  entry.build = build_method<Method>;
  entry.check = check_structure<Method>;
  std::size_t i = 0;
  TriangleTests::for_each([&](auto test) { entry.tests[i++] = make_test_entry<Method, typename decltype(test)::type>(); });
  return entry;
}

const std::vector<MethodEntry>& entries() {
  static const std::vector<MethodEntry> list = [] {
    std::vector<MethodEntry> result;
    Methods::for_each([&](auto method) { result.push_back(make_entry<typename decltype(method)::type>()); });
    return result;
  }();
  return list;
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
  static const std::vector<std::string> list = [] {
    std::vector<std::string> result;
    TriangleTests::for_each([&](auto test) { result.emplace_back(decltype(test)::type::kName); });
    return result;
  }();
  return list;
}

std::string best_method() { return "sbvh/stack"; }

Result<std::string> find_method(std::string_view name) {
  if (name == "best") return best_method();
  std::vector<std::string_view> names;
  for (const MethodInfo& info : methods()) {
    if (info.name == name) return info.name;
    names.push_back(info.name);
  }
  return unknown_name("method", name, names);
}

struct AnyAccel::State {
  AnyStructure structure;
  BuildReport report;
  const MethodEntry* entry;
};

Result<AnyAccel> AnyAccel::build(const TriangleMesh& mesh, std::string_view method, const BuildOptions& options) {
  const auto entry = find_entry(method);
  if (!entry) return entry.error();
  const Status valid = validate(mesh);
  if (!valid) return valid.error();
  return (*entry)->build(mesh, (*entry)->info, options);
}

Result<AnyAccel> AnyAccel::bind(AnyStructure structure, std::string_view method, BuildReport report) {
  const auto entry = find_entry(method);
  if (!entry) return entry.error();
  const Status fits = (*entry)->check(structure, (*entry)->info);
  if (!fits) return fits.error();
  return AnyAccel(std::make_shared<const State>(State{std::move(structure), std::move(report), *entry}));
}

Status AnyAccel::closest(std::span<const Ray> rays, std::span<Hit> hits, const TraceOptions& options) const {
  const auto test = find_test(options.test);
  if (!test) return test.error();
  if (Status s = same_size(rays, hits); !s) return s;
  state_->entry->tests[*test].closest(state_->structure, rays, hits, options.threads);
  return Done{};
}

Status AnyAccel::occluded(std::span<const Ray> rays, std::span<std::uint8_t> occluded, const TraceOptions& options) const {
  const auto test = find_test(options.test);
  if (!test) return test.error();
  if (Status s = same_size(rays, occluded); !s) return s;
  state_->entry->tests[*test].occluded(state_->structure, rays, occluded, options.threads);
  return Done{};
}

Hit AnyAccel::closest(const Ray& ray) const { return state_->entry->tests[0].closest_one(state_->structure, ray); }
bool AnyAccel::occluded(const Ray& ray) const { return state_->entry->tests[0].occluded_one(state_->structure, ray); }

Result<Counters> AnyAccel::count(std::span<const Ray> rays, Query query, std::span<std::uint32_t> steps,
                                 const TraceOptions& options) const {
  const auto test = find_test(options.test);
  if (!test) return test.error();
  if (!steps.empty())
    if (Status s = same_size(rays, steps); !s) return s.error();
  return state_->entry->tests[*test].count(state_->structure, rays, query, steps, options.threads);
}

Result<SimtProfile> AnyAccel::profile_simt(std::span<const Ray> rays, Query query, const SimtOptions& simt,
                                           const TraceOptions& options) const {
  const auto test = find_test(options.test);
  if (!test) return test.error();
  return state_->entry->tests[*test].simt(state_->structure, rays, query, simt, options.threads);
}

const MethodInfo& AnyAccel::method() const { return state_->entry->info; }
const AnyStructure& AnyAccel::structure() const { return state_->structure; }
const BuildReport& AnyAccel::report() const { return state_->report; }
std::size_t AnyAccel::size_bytes() const { return accel::size_bytes(state_->structure); }

}  // namespace accel
