#include "apps/common/command_line.h"

#include <charconv>
#include <cmath>
#include <map>

#include "apps/common/text.h"
#include "apps/common/versions.h"
#include "libaccel/core/suggest.h"
#include "libaccel/structure/grid.h"
#include "validation/compare/shell_quoted.h"

namespace accel::apps {

namespace {

// More are a mistake, and some machines refuse to start them.
constexpr std::uint64_t kMaxThreads = 1024;

// The whole of `text` as a number.
template <class Number>
bool parse_whole(const std::string& text, Number& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size();
}

const std::map<std::string, When>& when_names() {
  static const std::map<std::string, When> names = {
      {"auto", When::automatic}, {"always", When::always}, {"never", When::never}};
  return names;
}

CLI::Validator one_of_when() {
  return CLI::Validator(
      [](std::string& text) {
        const auto found = when_names().find(text);
        if (found == when_names().end()) return "'" + text + "' should be auto, always or never";
        text = std::to_string(static_cast<int>(found->second));
        return std::string();
      },
      "", "when");
}

// The first argument that no option took, with the option that was probably meant.
Failure unexpected(const CLI::App& app, const std::string& argument) {
  if (argument.rfind("-", 0) != 0)
    return {ExitStatus::usage, "unexpected argument '" + argument + "'; " +
                                   (app.get_option_no_throw("SCENE") != nullptr ? "one scene is expected, and " : "") +
                                   "lists are separated by commas"};
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  const std::string flag = argument.substr(0, argument.find('='));
  const std::vector<std::string_view> views(names.begin(), names.end());
  const auto match = closest_match(flag, views);
  return {ExitStatus::usage, "unknown option '" + flag + "'" + (match ? "; did you mean '" + std::string(*match) + "'?" : "") +
                                 (match ? "" : "; --help lists them all")};
}

}  // namespace

CLI::Validator whole_number(std::uint64_t least, std::uint64_t most) {
  return CLI::Validator(
      [least, most](std::string& text) {
        std::uint64_t value = 0;
        if (parse_whole(text, value) && value >= least && value <= most) return std::string();
        return "'" + text + "' should be a whole number from " + with_commas(least) + " to " + with_commas(most);
      },
      "", "whole number");
}

namespace {

// Cells along each axis, as in 50 (for all three) or 50x40x30.
std::string parse_resolution(const std::string& text, int (&cells)[3]) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == 'x')
      parts.emplace_back();
    else
      parts.back() += c;
  }
  bool good = parts.size() == 1 || parts.size() == 3;
  for (std::size_t a = 0; a < 3 && good; ++a) {
    const std::string& part = parts[parts.size() == 1 ? 0 : a];
    good = parse_whole(part, cells[a]) && cells[a] >= 1 && cells[a] <= kMaxGridResolution;
  }
  return good ? "" : "'" + text + "' should be N or NxNxN, with N from 1 to " + with_commas(kMaxGridResolution);
}

void add_grid_options(CLI::App& app, BuildOptions& options) {
  const auto resolution = [&](const CLI::results_t& texts) {
    const std::string complaint = parse_resolution(texts.front(), options.grid_resolution);
    if (!complaint.empty()) throw CLI::ValidationError("--grid-resolution", complaint);
    return true;
  };
  app.add_option("--grid-resolution", resolution, "grids: cells along each axis, N or NxNxN, in place of --grid-density")
      ->type_name("N")
      ->group("Build");
}

// Seconds alone ask for as many rounds as fit into them.
void add_reinsertion_options(CLI::App& app, BuildOptions& options) {
  CLI::Option* const rounds =
      app.add_option("--reinsertion-rounds", options.reinsertion_rounds,
                     "bvh, sbvh and bvh8: rounds that move subtrees to\nwhere they cost least; 0: none");
  rounds->check(whole_number(0, kMaxReinsertionRounds))->capture_default_str()->type_name("N")->group("Build");
  const auto seconds = [&options, rounds](const float& value) {
    options.reinsertion_seconds = value;
    if (value > 0 && rounds->count() == 0) options.reinsertion_rounds = kMaxReinsertionRounds;
  };
  app.add_option_function<float>(
         "--reinsertion-seconds", seconds,
         "no round begins after these seconds; without\n--reinsertion-rounds, as many as fit; 0: no limit")
      ->check(real_number(0, 1e6))
      ->default_str("0")
      ->type_name("X")
      ->group("Build");
}

}  // namespace

CLI::Validator real_number(double least, double most) {
  return CLI::Validator(
      [least, most](std::string& text) {
        double value = 0;
        if (parse_whole(text, value) && value >= least && value <= most) return std::string();
        return "'" + text + "' should be a number from " + short_number(least) + " to " + short_number(most);
      },
      "", "number");
}

void add_common_options(CLI::App& app, CommonSettings& settings) {
  app.set_help_flag();
  app.add_flag_callback(
         "-h,--help", [] {}, "show this help and exit")
      ->group("General");
  app.add_flag_callback(
         "--version", [] {}, "show versions and optional parts, and exit")
      ->group("General");
  app.add_option("--threads", settings.threads, "threads to use; 0: as many as the machine has")
      ->check(whole_number(0, kMaxThreads))
      ->capture_default_str()
      ->type_name("N")
      ->group("General");
  app.add_option("--seed", settings.seed, "seed of everything random")
      ->check(whole_number(0))
      ->capture_default_str()
      ->type_name("N")
      ->group("General");
  auto* quiet = app.add_flag_callback(
      "-q,--quiet", [&] { settings.verbosity = Verbosity::quiet; }, "no messages but errors");
  auto* verbose = app.add_flag_callback(
      "-v,--verbose", [&] { settings.verbosity = Verbosity::verbose; }, "say what is done, and why");
  quiet->group("General");
  verbose->excludes(quiet)->group("General");
  app.add_option("--progress", settings.progress, "progress bar: auto (after a second, on terminals), always, never")
      ->transform(one_of_when())
      ->type_name("WHEN")
      ->group("General");
  app.add_option("--color", settings.color, "colours: auto, always, never")
      ->transform(one_of_when())
      ->type_name("WHEN")
      ->group("General");
}

void add_build_options(CLI::App& app, BuildOptions& options) {
  const auto add = [&](const char* flag, auto& value, const char* what, CLI::Validator valid, const char* type) {
    app.add_option(flag, value, what)->check(std::move(valid))->capture_default_str()->type_name(type)->group("Build");
  };
  add("--max-leaf-size", options.max_leaf_size, "BVHs: most triangles in a leaf", whole_number(1, 1024), "N");
  add("--max-depth", options.max_depth, "most inner nodes on a path", whole_number(1, kMaxBuildDepth), "N");
  add("--bins", options.bins, "BVHs: bins of the surface-area heuristic, per axis", whole_number(2, kMaxBins), "N");
  add("--traversal-cost", options.traversal_cost, "cost of a step through a node", real_number(1e-3, 1e6), "X");
  add("--intersection-cost", options.intersection_cost, "cost of a triangle test", real_number(1e-3, 1e6), "X");
  add("--spatial-overlap", options.spatial_overlap, "sbvh: least overlap for a spatial split, as a share\nof the root",
      real_number(0, 1), "X");
  add("--max-duplication", options.max_duplication, "sbvh: extra references that spatial splits may make,\nper triangle",
      real_number(0, kMaxDuplication), "X");
  add_reinsertion_options(app, options);
  add("--empty-bonus", options.empty_bonus, "kd-trees: share by which planes that cut off\nempty space are cheaper",
      real_number(0, 0.99), "X");
  add("--max-references", options.max_references, "kd-trees and grids: most references in the leaves,\nper triangle",
      real_number(1, kMaxKdReferences), "X");
  add("--grid-density", options.grid_density, "grids: cells per triangle; 0: as the cost model\nof the build wants",
      real_number(0, kMaxGridDensity), "X");
  add_grid_options(app, options);
}

Outcome<std::string> parse_arguments(CLI::App& app, int argc, char** argv, CommonSettings& settings) {
  settings.command_line = app.get_name();
  for (int i = 1; i < argc; ++i) settings.command_line += " " + validation::shell_quoted(argv[i]);
  for (int i = 1; i < argc; ++i) {
    const std::string_view argument = argv[i];
    if (argument == "-h" || argument == "--help") return app.help();
    if (argument == "--version") return versions_text(app.get_name());
  }
  app.allow_extras();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ArgumentMismatch& error) {
    const std::string text = error.what();
    const bool is_repeated = text.find("At Most") != std::string::npos;
    return Failure(ExitStatus::usage,
                   text.substr(0, text.find(": ")) +
                       (is_repeated ? ": is given twice; give it once" : ": its value is missing; --help says what it takes"));
  } catch (const CLI::ParseError& error) {
    return Failure(ExitStatus::usage, error.what());
  }
  std::vector<std::string> remaining = app.remaining();
  std::erase(remaining, "--");  // what follows is no option: CLI11 knows that, and keeps the mark
  if (!remaining.empty()) return unexpected(app, remaining.front());
  for (const CLI::Option* option : app.get_options())
    if (option->count() > 0 && option->get_items_expected_max() > 0 && option->results().front().empty())
      return Failure(ExitStatus::usage, option->get_name() + ": its value is empty; leave it out, or say what it is");
  return std::string();
}

}  // namespace accel::apps
