#include "apps/common/method_set.h"

#include <algorithm>
#include <map>

#include "apps/common/ray_batch.h"
#include "apps/common/text.h"

namespace accel::apps {

namespace {

const MethodInfo& method_info(const std::string& name) {
  return *std::find_if(methods().begin(), methods().end(), [&](const MethodInfo& m) { return m.name == name; });
}

// Whether instances are kept apart when the user does not say.
bool keeps_instances(const Scene& scene) { return scene.data.instances && (scene.stored || scene.data.is_better_apart()); }

// The method to use when the user does not say.
std::string best_for(const Scene& scene) {
  return best_method({.builder = scene.stored ? scene.stored->builder : "", .instances = keeps_instances(scene)});
}

// Why "all" leaves a method out; empty if it does not.
std::string reason_to_skip(const MethodInfo& method, const Scene& scene, std::uint64_t rays, bool sweep) {
  if (!method.robust && !sweep) return "it is known to lose hits; name it, or compare it with --sweep";
  if (method.instances && !scene.stored && !scene.data.instances)
    return "the scene has no instances; if named, it takes all as one";
  if (scene.stored && method.builder != scene.stored->builder)
    return "the file holds a structure built by '" + scene.stored->builder + "'";
  const std::uint64_t triangles = std::max<std::uint64_t>(scene.facts.triangles, 1);
  if (method.exhaustive && rays > kMostExhaustiveTests / triangles)
    return counted(rays, "ray") + " times " + counted(triangles, "triangle") + " are more than " +
           with_commas(kMostExhaustiveTests) + " tests; name the method to run it";
  return {};
}

std::vector<std::string> resolve(const Scene& scene, const TraceSettings& settings, std::vector<Skip>& skipped) {
  std::vector<std::string> names;
  if (settings.methods.front() != "all") {
    for (const std::string& name : settings.methods) {
      const std::string actual = name != "best" ? name : best_for(scene);
      if (name == "best" && scene.data.instances && !keeps_instances(scene))
        skipped.push_back({"instances", "one mesh of " + counted(scene.facts.triangles, "triangle") +
                                            " is faster to trace; --method bvh8-instances/stream keeps them apart"});
      if (std::find(names.begin(), names.end(), actual) == names.end()) names.push_back(actual);
    }
    return names;
  }
  std::uint64_t rays = 0;
  for (const std::string& kind : settings.ray_kinds) rays = std::max(rays, most_rays(settings, kind));
  for (const MethodInfo& m : methods()) {
    const std::string reason = reason_to_skip(m, scene, rays, settings.sweep);
    if (reason.empty())
      names.push_back(m.name);
    else
      skipped.push_back({m.name, reason});
  }
  return names;
}

Outcome<AnyAccel> bind_stored(const Scene& scene, const MethodInfo& method) {
  const StoredStructure& stored = *scene.stored;
  if (method.builder != stored.builder)
    return Failure(ExitStatus::error, "'" + scene.name + "' holds a structure built by '" + stored.builder + "', which " +
                                          method.name + " does not use; try --method " + best_for(scene) +
                                          ", or trace the scene itself");
  auto accel = AnyAccel::bind(stored.structure, method.name, stored.report);
  if (!accel) return accel.error();
  return *std::move(accel);
}

Outcome<AnyAccel> build(const Scene& scene, const MethodInfo& method, const TraceSettings& settings, ProgressBar& bar) {
  bar.begin("building " + method.builder);
  BuildOptions options = settings.build;
  options.progress = bar.callback();
  auto accel = scene.data.instances ? AnyAccel::build(*scene.data.instances, method.name, options)
                                    : AnyAccel::build(scene.data.mesh, method.name, options);
  if (!accel) return accel.error();
  return *std::move(accel);
}

}  // namespace

Outcome<MethodSet> prepare_methods(const Scene& scene, const TraceSettings& settings, ProgressBar& bar,
                                   std::vector<Skip>& skipped) {
  MethodSet set;
  std::map<std::string, std::size_t> member_of_builder;
  for (const std::string& name : resolve(scene, settings, skipped)) {
    const MethodInfo& method = method_info(name);
    const auto sibling = member_of_builder.find(method.builder);
    if (sibling != member_of_builder.end()) {
      const MethodSet::Member& member = set.members[sibling->second];
      auto accel = member.accel.with_method(name);
      if (!accel) return accel.error();
      set.members.push_back({*std::move(accel), member.structure});
      continue;
    }
    auto accel = scene.stored ? bind_stored(scene, method) : build(scene, method, settings, bar);
    if (!accel) return accel.failure();
    member_of_builder[method.builder] = set.members.size();
    const double build_seconds = scene.stored ? 0 : accel->report().seconds;  // files hold no times
    set.structures.push_back({method.builder, build_seconds, accel->size_bytes(), accel->report(),
                              facts_of(accel->structure(), scene.stored ? scene.stored_costs : settings.build, Detail::quick)});
    set.members.push_back({*std::move(accel), set.structures.size() - 1});
  }
  return set;
}

}  // namespace accel::apps
