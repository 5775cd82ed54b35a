#include "apps/common/build_options.h"

#include <algorithm>
#include <vector>

#include "apps/common/command_line.h"
#include "apps/common/output.h"
#include "apps/common/text.h"
#include "libaccel/core/suggest.h"
#include "libaccel/registry/any_accel.h"

namespace accel::apps {

namespace {

constexpr const char* kBuildDescription =
    "Builds an acceleration structure and writes it, with its scene, to a file for accel-trace.";

constexpr const char* kBuildExamples =
    "Examples:\n"
    "  accel-build scene.ply.zst -o scene.accel               the recommended structure\n"
    "  accel-build scene.obj -o scene.accel --structure bvh --max-leaf-size 4\n"
    "  accel-build scene.ply -o scene.accel --for sbvh/stack  whatever this method traces\n"
    "  accel-build builtin:hairball:1M --stats                quality only: nothing is written\n"
    "\n"
    "Exit status: 0 all is well, 1 bad input or failure, 2 bad command line, 130 interrupted\n"
    "(143 by SIGTERM).";

// The builders of all methods, each once.
std::vector<std::string_view> builders() {
  std::vector<std::string_view> names;
  for (const MethodInfo& m : methods())
    if (std::find(names.begin(), names.end(), m.builder) == names.end()) names.push_back(m.builder);
  return names;
}

// The first method of a builder.
std::string method_of(const std::string& builder) {
  for (const MethodInfo& m : methods())
    if (m.builder == builder) return m.name;
  return {};
}

// The method to build for, which --structure and --for agree on; by default none.
Outcome<std::string> choose_method(const std::string& structure, const std::string& method) {
  const std::vector<std::string_view> known = builders();
  if (!structure.empty() && std::find(known.begin(), known.end(), structure) == known.end())
    return usage_error("--structure: " + unknown_name("structure", structure, known).message);
  if (method.empty()) return structure.empty() ? std::string() : method_of(structure);
  const Result<std::string> found = find_method(method);
  if (!found) return usage_error("--for: " + found.message());
  const std::string builder = builder_of(*found);
  if (!structure.empty() && structure != builder)
    return usage_error("--structure " + structure + " and --for " + method + " contradict each other: " + *found + " traces '" +
                       builder + "'");
  return *found;
}

}  // namespace

std::string builder_of(const std::string& method) {
  for (const MethodInfo& m : methods())
    if (m.name == method) return m.builder;
  return {};
}

Outcome<BuildSettings> parse_build_options(int argc, char** argv) {
  CLI::App app(kBuildDescription, "accel-build");
  BuildSettings settings;
  std::string structure, method;
  app.add_option("SCENE", settings.scene, ".ply, .obj, .gltf, .glb (or any .zst), or builtin:NAME[:size]")->type_name("");
  app.add_option("-o,--output", settings.output, "structure file to write, ending in .accel")
      ->type_name("FILE")
      ->group("Output");
  app.add_flag("--stats", settings.stats, "histograms and end-point overlap too; with it, -o may be left out")->group("Output");
  app.add_flag("--explain", settings.explain, "what the build left out or added, and why")->group("Output");
  app.add_option("--json", settings.json, "report as JSON; - is standard output, in place of the text")
      ->type_name("FILE")
      ->group("Output");
  std::vector<std::string> names;
  for (const std::string_view name : builders()) names.emplace_back(name);
  std::string list = wrapped("what to build [" + builder_of(best_method()) + ", of large scenes of copies " +
                                 builder_of(best_method({.instances = true})) + "]: " + join(names, ", "),
                             66, "");
  list.pop_back();
  app.add_option("-s,--structure", structure, list)->type_name("NAME")->group("Build");
  app.add_option("--for", method, "build what this method traces, with the arrays that it reads")
      ->type_name("METHOD")
      ->group("Build");
  app.add_flag("--list", settings.list, "list methods, structures and built-in scenes, and exit")->group("General");
  add_build_options(app, settings.build);
  add_common_options(app, settings.common);
  app.footer(kBuildExamples);

  auto answer = parse_arguments(app, argc, argv, settings.common);
  if (!answer) return answer.failure();
  settings.help = *answer;
  settings.build.threads = settings.common.threads;
  if (!settings.help.empty() || settings.list) return settings;
  if (settings.scene.empty()) return usage_error("which scene? give a file or builtin:NAME; --list shows the built-in ones");
  if (settings.scene.ends_with(".accel"))
    return usage_error("'" + settings.scene + "' is a structure already; give the scene it was built from");
  if (settings.output.empty() && !settings.stats && settings.json.empty())
    return usage_error("where to? give -o FILE.accel, or --stats to build and only report");
  if (!settings.output.empty() && !settings.output.ends_with(".accel"))
    return usage_error("--output: '" + settings.output + "' should end in .accel, which is how accel-trace knows it");
  auto chosen = choose_method(structure, method);
  if (!chosen) return chosen.failure();
  settings.method = *std::move(chosen);
  if (auto writable = check_outputs({{"--output", settings.output}, {"--json", settings.json}}, {settings.scene}); !writable)
    return writable.failure();
  return settings;
}

}  // namespace accel::apps
