#include "apps/common/trace_options.h"

#include <algorithm>
#include <array>
#include <initializer_list>
#include <iterator>
#include <utility>

#include "apps/common/command_line.h"
#include "apps/common/embree_modes.h"
#include "apps/common/image.h"
#include "apps/common/output.h"
#include "apps/common/scaling.h"
#include "apps/common/text.h"
#include "libaccel/core/suggest.h"
#include "libaccel/io/npy.h"
#include "libaccel/rays/ray_kind.h"
#include "libaccel/rays/ray_sets.h"
#include "libaccel/registry/any_accel.h"
#include "scenes/procedural.h"

namespace accel::apps {

namespace {

constexpr const char* kTraceDescription =
    "Builds ray-tracing acceleration structures, traces rays through them and checks every hit.\n"
    "Without a scene: builtin:stadium with the best method, checked.";

constexpr const char* kTraceExamples =
    "Examples:\n"
    "  accel-trace                                        the demo\n"
    "  accel-trace scene.ply --method all --rays primary,shadow,diffuse\n"
    "                                                     which method is fastest here, and is it right?\n"
    "  accel-trace scene.obj --camera 2 --image view.png --heatmap heat.png\n"
    "                                                     what it looks like, and where the time goes\n"
    "  accel-trace builtin:hairball:1M --rays edge --count 1000000 --check exact\n"
    "                                                     how many rays leak through edges?\n"
    "  accel-trace scene.accel --rays mine.npy --hits-out hits.npy --check none\n"
    "                                                     rays and hits of your own, for NumPy\n"
    "  accel-trace scene.ply --profile simt --json -      for scripts, in Google Benchmark's shape\n"
    "  accel-trace stress --help                          stress tests of numerical stability\n"
    "\n"
    "Exit status: 0 all is well, 1 bad input or failure, 2 bad command line, 3 a wrong hit was found,\n"
    "5 a backend is not built in or has no device, 130 interrupted (143 by SIGTERM).";

// The command line as typed, before names are looked up.
struct RawTraceOptions {
  std::string methods = "best", rays, query, check = "embree", embree, sort, scaling, profile, schedule, device = "cpu",
              heatmap_of = "steps", pixel_order = order_name(PixelOrder::rows);
};

struct ScheduleName {
  std::string_view name;
  SimtSchedule schedule;
};
constexpr std::array<ScheduleName, 5> kSchedules = {{{"while-while", SimtSchedule::while_while},
                                                     {"if-if", SimtSchedule::if_if},
                                                     {"speculative", SimtSchedule::speculative_while_while},
                                                     {"persistent", SimtSchedule::persistent_while_while},
                                                     {"if-while", SimtSchedule::if_while}}};

void add_what(CLI::App& app, TraceSettings& settings, RawTraceOptions& raw) {
  app.add_option("SCENE", settings.scene, ".ply, .obj, .gltf, .glb (or any .zst), .accel, or builtin:NAME[:size]")
      ->type_name("");
  app.add_option("-m,--method", raw.methods, "methods (builder/traverser), best, or all")
      ->capture_default_str()
      ->type_name("NAME,...")
      ->group("What to trace");
  app.add_option("-r,--rays", raw.rays, "kinds of rays, or .npy files [primary]")
      ->type_name("KIND,...|FILE")
      ->group("What to trace");
  app.add_option(
         "--query", raw.query,
         "what is asked of all rays: closest or any hit [as renderers ask of\nthe kind, see --list; closest of .npy files]")
      ->type_name("NAME")
      ->group("What to trace");
  app.add_option("--test", settings.test, "triangle test; --list has all [" + triangle_tests().front() + "]")
      ->type_name("NAME")
      ->group("What to trace");
  app.add_option("--device", raw.device, "cpu or cuda")->capture_default_str()->type_name("NAME")->group("What to trace");
  app.add_flag("--list", settings.list, "list methods, tests, kinds of rays and built-in scenes, and exit")
      ->group("What to trace");
}

// Of rays that are sorted or traced together. Hits do not depend on them.
void add_packet_options(CLI::App& app, PacketOptions& packets) {
  app.add_option("--cell-fraction", packets.cell_fraction,
                 "ray-hash, breadth-first, stream: cells of origins, as a share of\nthe scene's diagonal")
      ->check(real_number(2e-5, 1))
      ->capture_default_str()
      ->type_name("X")
      ->group("Measuring and checking");
  app.add_option("--packet-size", packets.max_size, "breadth-first, stream: most rays in a packet")
      ->check(whole_number(1, kMaxPacketSize))
      ->capture_default_str()
      ->type_name("N")
      ->group("Measuring and checking");
  app.add_option("--packet-block", packets.block_size,
                 "breadth-first, stream: rays that are prepared together; each takes\nsome 40 bytes of memory in each thread")
      ->check(whole_number(1, 1u << 28))
      ->capture_default_str()
      ->type_name("N")
      ->group("Measuring and checking");
}

void add_rays(CLI::App& app, TraceSettings& settings, RawTraceOptions& raw) {
  const auto add = [&](const char* flag, auto& value, const char* what, CLI::Validator valid) {
    app.add_option(flag, value, what)->check(std::move(valid))->capture_default_str()->type_name("N")->group("Rays");
  };
  add("--width", settings.width, "width of the picture, in pixels", whole_number(1, 65536));
  add("--height", settings.height, "height of the picture, in pixels", whole_number(1, 65536));
  add("--spp", settings.spp, "rays a pixel", whole_number(1, 65536));
  app.add_option("--pixel-order", raw.pixel_order,
                 "in which rays of pixels come: by rows, or along a z-curve, by tiles\nwithin tiles, as renderers trace them")
      ->capture_default_str()
      ->type_name("NAME")
      ->group("Rays");
  app.add_option("--count", settings.count, "rays of kinds that have no pixels (random, edge) [width x height]")
      ->check(whole_number(1, kMaxRays))
      ->type_name("N")
      ->group("Rays");
  app.add_option("--camera", settings.camera,
                 "eye, at, up and vertical angle: EX,EY,EZ,AX,AY,AZ,UX,UY,UZ,VFOV;\n"
                 "or the name or number of one of the scene's cameras [the first]")
      ->type_name("CAMERA")
      ->group("Rays");
}

void add_measuring(CLI::App& app, TraceSettings& settings, RawTraceOptions& raw) {
  app.add_option("--repeat", settings.repeat, "timed runs of each method")
      ->check(whole_number(1, 100000))
      ->capture_default_str()
      ->type_name("N")
      ->group("Measuring and checking");
  app.add_option("--check", raw.check,
                 "embree (what it agrees with is taken as right, but for a sample; all\nelse is judged exactly), exact (all "
                 "judged), or none")
      ->capture_default_str()
      ->type_name("WHO")
      ->group("Measuring and checking");
  app.add_option("--embree", raw.embree,
                 "modes of Embree to time: fast (always, ratios refer to it),\n"
                 "robust, high, packet8, packet16, stream, the last three with -m\n"
                 "of medium quality, or all [fast]")
      ->type_name("MODE,...")
      ->group("Measuring and checking");
  app.add_option("--judge-limit", settings.judge_limit, "most rays to judge exactly, for each method and kind [no limit]")
      ->check(whole_number(1))
      ->type_name("N")
      ->group("Measuring and checking");
  app.add_flag("--sweep", settings.sweep,
               "run time against error: every method with every triangle test,\n"
               "edge rays always among the rays; by default 512 x 384 pixels,\n"
               "3 runs, all methods, primary and diffuse rays")
      ->group("Measuring and checking");
  app.add_option("--max-error", settings.max_error,
                 "sweeps: recommend the fastest with at most so many wrong hits per\nmillion [what is promised to have none]")
      ->check(real_number(0, 1e6))
      ->type_name("X")
      ->group("Measuring and checking");
  app.add_option("--scaling", raw.scaling,
                 "how time, build and memory grow: the methods on the first kind of\n"
                 "rays in the built-in scene of these sizes, such as 1k,30k,1M")
      ->type_name("SIZE,...")
      ->group("Measuring and checking");
  app.add_option("--sort", raw.sort,
                 "measure the rays sorted, too, by ray-hash or morton: what that\n"
                 "costs and gains each method")
      ->type_name("NAME")
      ->group("Measuring and checking");
  add_packet_options(app, settings.packets);
  app.add_option("--profile", raw.profile,
                 "what the rays would cost: simt, in warps of 32 lanes;\n"
                 "multipass, as streams through small kernels")
      ->type_name("MODEL,...")
      ->group("Measuring and checking");
  app.add_option("--schedule", raw.schedule,
                 "warps: while-while, if-if, if-while, speculative or persistent\n"
                 "[while-while];\n"
                 "passes: delany, largest-first or drain [delany]")
      ->type_name("NAME,...")
      ->group("Measuring and checking");
  app.add_option("--batch", settings.multipass.batch_size, "rays in flight between passes")
      ->check(whole_number(1, 1u << 31))
      ->capture_default_str()
      ->type_name("N")
      ->group("Measuring and checking");
  app.add_flag("--compact", settings.multipass.compact, "passes run over lists of rays instead of masking the others")
      ->group("Measuring and checking");
}

std::vector<std::string> ray_counters() {
  std::vector<std::string> names;
  for (int c = 0; c < kRayCounters; ++c) names.emplace_back(counter_name(static_cast<RayCounter>(c)));
  return names;
}

void add_outputs(CLI::App& app, TraceSettings& settings, RawTraceOptions& raw) {
  const auto add = [&](const char* flag, std::string& path, const char* what) {
    app.add_option(flag, path, what)->type_name("FILE")->group("Output");
  };
  add("--json", settings.json, "in Google Benchmark's shape; - is standard output, instead of tables");
  add("--report", settings.report, "one page with plots, tables and pictures, which opens offline (.html)");
  add("--image", settings.image, "the view, shaded by normal (.png, .exr, .jpg, .tif)");
  add("--heatmap", settings.heatmap, "cost of each ray of the first method and kind, with a legend");
  app.add_option("--heatmap-of", raw.heatmap_of, "its counter: " + join(ray_counters(), ", "))
      ->capture_default_str()
      ->type_name("NAME")
      ->group("Output");
  add("--diff", settings.diff, "difference from the witness and verdicts, of the first method and kind");
  add("--rays-out", settings.rays_out, "the rays of the first kind, as .npy");
  add("--hits-out", settings.hits_out, "their hits, by the first method; of any-hit kinds t = 0 if occluded");
  app.add_option("--hits", settings.hits, "how many hits of each ray, the nearest first; of all kinds")
      ->check(whole_number(1, 1u << 16))
      ->type_name("K")
      ->group("Output");
  app.add_flag("--explain", settings.explain, "what builds left out or added for the methods, and why")->group("Output");
  add("--repro", settings.repro, "how names of files that reproduce wrong hits begin [accel-repro]");
}

Failure unknown(std::string_view flag, std::string_view what, std::string_view name,
                const std::vector<std::string_view>& known) {
  return usage_error(std::string(flag) + ": " + unknown_name(what, name, known).message);
}

// Method names, "best" resolved and repetitions dropped; "all" stands for itself.
Outcome<std::vector<std::string>> parse_methods(const std::string& text) {
  std::vector<std::string> result;
  for (const std::string& name : split(text, ',')) {
    if (name == "all") return std::vector<std::string>{"all"};
    const Result<std::string> found = find_method(name);
    if (!found) return usage_error("--method: " + found.message());
    if (name == "best")
      result.push_back(name);
    else if (std::find(result.begin(), result.end(), *found) == result.end())
      result.push_back(*found);
  }
  return result;
}

bool is_npy(const std::string& name) { return name.ends_with(".npy"); }

Outcome<std::vector<std::string>> parse_ray_kinds(const std::string& text) {
  std::vector<std::string> result;
  for (const std::string& name : split(text, ',')) {
    if (const auto kind = parse_ray_kind(name); !is_npy(name) && !kind) return usage_error("--rays: " + kind.message());
    if (std::find(result.begin(), result.end(), name) == result.end()) result.push_back(name);
  }
  return result;
}

Outcome<Check> parse_check(const std::string& name) {
  if (name == "embree") return Check::embree;
  if (name == "exact") return Check::exact;
  if (name == "none") return Check::none;
  return unknown("--check", "checker", name, {"embree", "exact", "none"});
}

// The parts of a list of names; none of an empty one.
std::vector<std::string> names_of(const std::string& text) {
  return text.empty() ? std::vector<std::string>() : split(text, ',');
}

Outcome<std::vector<std::string>> parse_embree_modes(const std::string& text) {
  std::vector<std::string_view> known;
  for (const EmbreeTimed& timed : kEmbreeModes) known.push_back(timed.name);
  known.emplace_back("all");
  std::vector<std::string> names = names_of(text);
  for (const std::string& name : names)
    if (std::find(known.begin(), known.end(), name) == known.end()) return unknown("--embree", "mode of Embree", name, known);
  return names;
}

Finished parse_profiles(const std::string& text, TraceSettings& settings) {
  for (const std::string& name : names_of(text)) {
    if (name != "simt" && name != "multipass") return unknown("--profile", "profile", name, {"simt", "multipass"});
    (name == "simt" ? settings.profile_simt : settings.profile_multipass) = true;
  }
  return Done{};
}

// Both models' schedules, which have no name in common: at most one of each model that is asked for.
Finished parse_schedules(const std::string& text, TraceSettings& settings) {
  bool has_simt = false, has_multipass = false;
  for (const std::string& name : names_of(text)) {
    std::vector<std::string_view> known;
    bool is_simt = false, is_multipass = false;
    for (const ScheduleName& s : kSchedules) {
      known.push_back(s.name);
      if (s.name == name) settings.schedule = s.schedule, is_simt = true;
    }
    for (int r = 0; r < kMultipassRules; ++r) {
      const auto rule = static_cast<MultipassRule>(r);
      known.emplace_back(rule_name(rule));
      if (known.back() == name) settings.multipass.rule = rule, is_multipass = true;
    }
    if (!is_simt && !is_multipass) return unknown("--schedule", "schedule", name, known);
    const std::string subject = "--schedule: '" + name + "' is about " + (is_simt ? "warps" : "passes");
    if (!(is_simt ? settings.profile_simt : settings.profile_multipass))
      return usage_error(subject + "; add --profile " + (is_simt ? "simt" : "multipass"));
    if (std::exchange(is_simt ? has_simt : has_multipass, true))
      return usage_error(subject + ", as a name before it; give one of them");
  }
  return Done{};
}

Outcome<RayCounter> parse_counter(const std::string& name) {
  const std::vector<std::string> known = ray_counters();
  const auto found = std::find(known.begin(), known.end(), name);
  if (found == known.end()) return unknown("--heatmap-of", "counter", name, {known.begin(), known.end()});
  return static_cast<RayCounter>(found - known.begin());
}

Outcome<PixelOrder> parse_pixel_order(const std::string& name) {
  for (const PixelOrder order : {PixelOrder::rows, PixelOrder::z_curve})
    if (name == order_name(order)) return order;
  return unknown("--pixel-order", "order", name, {order_name(PixelOrder::rows), order_name(PixelOrder::z_curve)});
}

// Looks names up and turns the raw options into settings.
Finished interpret(const RawTraceOptions& raw, TraceSettings& settings) {
  auto methods = parse_methods(raw.methods);
  if (!methods) return methods.failure();
  settings.methods = *std::move(methods);

  constexpr const char *kDemoRays = "primary,shadow,diffuse,edge", *kSweptRays = "primary,diffuse,edge";
  auto kinds = parse_ray_kinds(!raw.rays.empty()  ? raw.rays
                               : settings.sweep   ? kSweptRays
                               : settings.is_demo ? kDemoRays
                                                  : "primary");
  if (!kinds) return kinds.failure();
  settings.ray_kinds = *std::move(kinds);
  const std::string edge(info(RayKind::edge).name);
  if (settings.sweep && std::find(settings.ray_kinds.begin(), settings.ray_kinds.end(), edge) == settings.ray_kinds.end())
    settings.ray_kinds.push_back(edge);

  const auto order = parse_pixel_order(raw.pixel_order);
  if (!order) return order.failure();
  settings.pixel_order = *order;

  if (!raw.query.empty() && raw.query != "closest" && raw.query != "any")
    return unknown("--query", "query", raw.query, {"closest", "any"});
  if (!raw.query.empty()) settings.query = raw.query == "any" ? Query::any : Query::closest;

  const auto check = parse_check(raw.check);
  if (!check) return check.failure();
  settings.check = *check;

  auto embree = parse_embree_modes(raw.embree);
  if (!embree) return embree.failure();
  settings.embree = *std::move(embree);

  if (!raw.sort.empty()) {
    const auto sort = parse_ray_sort(raw.sort);
    if (!sort) return usage_error("--sort: " + sort.message());
    settings.sort = *sort;
  }
  settings.scaling = names_of(raw.scaling);
  if (auto done = parse_profiles(raw.profile, settings); !done) return done;
  if (auto done = parse_schedules(raw.schedule, settings); !done) return done;
  const auto counter = parse_counter(raw.heatmap_of);
  if (!counter) return counter.failure();
  settings.heatmap_of = *counter;
  if (raw.device != "cpu" && raw.device != "cuda") return unknown("--device", "device", raw.device, {"cpu", "cuda"});
  settings.device = raw.device;

  const std::vector<std::string>& tests = triangle_tests();
  if (!settings.test.empty() && std::find(tests.begin(), tests.end(), settings.test) == tests.end())
    return unknown("--test", "triangle test", settings.test, {tests.begin(), tests.end()});
  return Done{};
}

bool has_pixels(const std::string& rays) { return !is_npy(rays) && info(*parse_ray_kind(rays)).is_image; }
bool is_counted(const std::string& rays) { return !is_npy(rays) && !has_pixels(rays); }

// Options that contradict one another, and outputs that could not be written, found before any work is done.
Finished check_consistency(const TraceSettings& settings) {
  if (std::uint64_t{settings.width} * settings.height * settings.spp > kMaxRays)
    return usage_error("--width, --height, --spp: " + std::to_string(settings.width) + " x " + std::to_string(settings.height) +
                       " x " + std::to_string(settings.spp) + " rays are more than " + with_commas(kMaxRays) +
                       "; make one of them smaller");
  for (const auto& [flag, path] :
       {std::pair{"--image", &settings.image}, {"--heatmap", &settings.heatmap}, {"--diff", &settings.diff}}) {
    if (path->empty()) continue;
    if (auto valid = check_image_name(*path, flag); !valid) return valid;
  }
  const std::string& first = settings.ray_kinds.front();
  for (const auto& [flag, path] : {std::pair{"--heatmap", &settings.heatmap}, {"--diff", &settings.diff}})
    if (!path->empty() && !has_pixels(first))
      return usage_error(std::string(flag) + ": rays of kind '" + first +
                         "' belong to no pixels; put a kind that does first in --rays");
  if (!settings.diff.empty() && settings.check == Check::none)
    return usage_error("--diff: needs a witness; leave out --check none");
  for (const auto& [flag, path] : {std::pair{"--rays-out", &settings.rays_out}, {"--hits-out", &settings.hits_out}})
    if (!path->empty() && !is_npy(*path)) return usage_error(std::string(flag) + ": '" + *path + "' should end in .npy");
  if (!settings.scaling.empty() && !settings.scene.starts_with("builtin:"))
    return usage_error("--scaling: '" + settings.scene + "' has one size; only built-in scenes have others");
  if (!settings.scaling.empty() && is_npy(settings.ray_kinds.front()))
    return usage_error("--scaling: rays of a file fit one size of a scene; name a kind of rays");
  for (const std::string& size : settings.scaling)
    if (const Status good = check_builtin(scene_of_size(settings.scene, size)); !good)
      return usage_error("--scaling: " + good.message());
  if (settings.max_error && !settings.sweep) return usage_error("--max-error: is about sweeps; add --sweep");
  if (settings.sweep && settings.check == Check::none) return usage_error("--sweep: measures errors; leave out --check none");
  if (settings.sweep && settings.device != "cpu")
    return usage_error("--sweep: is for the CPU; leave out --device " + settings.device);
  if (settings.sweep && settings.sort) return usage_error("--sweep: and --sort are measured one at a time");
  if (settings.sweep && (settings.profile_simt || settings.profile_multipass))
    return usage_error("--sweep: and --profile are measured one at a time");
  if (settings.hits > 0 && settings.hits_out.empty()) return usage_error("--hits: needs --hits-out, a file for them");
  InputFiles inputs{settings.scene};
  std::copy_if(settings.ray_kinds.begin(), settings.ray_kinds.end(), std::back_inserter(inputs.others), is_npy);
  for (const std::string& path : inputs.others)
    if (const auto rays = count_rays_npy(path); !rays) return rays.error();
  return check_outputs({{"--json", settings.json},
                        {"--report", settings.report},
                        {"--image", settings.image},
                        {"--heatmap", settings.heatmap},
                        {"--diff", settings.diff},
                        {"--rays-out", settings.rays_out},
                        {"--hits-out", settings.hits_out}},
                       inputs);
}

// Options that would do nothing, since nothing that they are about was asked for.
Finished refuse_idle_options(const CLI::App& app, const TraceSettings& settings) {
  const auto any_rays = [&](bool (*condition)(const std::string&)) {
    return std::any_of(settings.ray_kinds.begin(), settings.ray_kinds.end(), condition);
  };
  const bool has_packets = std::any_of(settings.methods.begin(), settings.methods.end(), [](const std::string& method) {
    return method == "best" || method == "all" || makes_packets(method);
  });
  const struct {
    const char* flag;
    bool has_effect;
    const char* message;
  } options[] = {
      {"--batch", settings.profile_multipass, "is about passes; add --profile multipass"},
      {"--compact", settings.profile_multipass, "is about passes; add --profile multipass"},
      {"--judge-limit", settings.check != Check::none, "is about checking; leave out --check none"},
      {"--repro", settings.check != Check::none, "is about wrong hits, for which nobody looks; leave out --check none"},
      {"--packet-size", has_packets, "is about methods that make packets of rays, which none of --method do"},
      {"--packet-block", has_packets, "is about methods that make packets of rays, which none of --method do"},
      {"--cell-fraction", has_packets || settings.sort == RaySort::ray_hash,
       "is about methods that make packets of rays, which none of --method do, and about --sort ray-hash"},
      {"--camera", any_rays(has_pixels) || !settings.image.empty(), "is about rays that have pixels, which none of --rays do"},
      {"--heatmap-of", !settings.heatmap.empty() || !settings.report.empty(), "is about heat maps; add --heatmap or --report"},
      {"--count", any_rays(is_counted), "is about rays that have no pixels; put random or edge into --rays"},
      {"--pixel-order", any_rays(has_pixels), "is about rays that have pixels, which none of --rays do"},
      {"--spp", any_rays(has_pixels) || !settings.image.empty(), "is about rays that have pixels, which none of --rays do"}};
  for (const auto& [flag, has_effect, message] : options)
    if (app.count(flag) > 0 && !has_effect) return usage_error(std::string(flag) + ": " + message);
  return Done{};
}

// A structure file is built already: options of builders would do nothing.
Finished refuse_build_options(const CLI::App& app, const TraceSettings& settings) {
  if (!settings.scene.ends_with(".accel")) return Done{};
  for (const CLI::Option* option : app.get_options())
    if (option->get_group() == "Build" && option->count() > 0)
      return usage_error(option->get_name() + ": '" + settings.scene + "' is built already; give this option to accel-build");
  return Done{};
}

// What a repro bundle repeats. Packets decide no hits unless something is wrong with them.
void keep_hit_options(const CLI::App& app, TraceSettings& settings) {
  const auto is_one_of = [](const std::string& name, std::initializer_list<std::string_view> names) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  for (const CLI::Option* option : app.get_options()) {
    const std::string name = option->get_name();
    const bool is_of_packets = is_one_of(name, {"--cell-fraction", "--packet-size", "--packet-block"});
    const bool decides = is_of_packets || option->get_group() == "Build" || is_one_of(name, {"--seed", "--device"});
    if (!decides || option->count() == 0) continue;
    std::vector<std::string>& arguments = is_of_packets ? settings.packet_options : settings.hit_options;
    arguments.push_back(name);
    for (const std::string& value : option->results()) arguments.push_back(value);
  }
}

// A sweep measures a hundred configurations: fewer rays and runs, unless the user says so.
void apply_sweep_defaults(const CLI::App& app, TraceSettings& settings, RawTraceOptions& raw) {
  const auto unless_given = [&](const char* flag, auto& value, auto standard) {
    if (app.count(flag) == 0) value = standard;
  };
  unless_given("--width", settings.width, 512u);
  unless_given("--height", settings.height, 384u);
  unless_given("--repeat", settings.repeat, 3);
  unless_given("--method", raw.methods, std::string("all"));
  unless_given("--embree", raw.embree, std::string("robust"));
}

}  // namespace

bool makes_packets(std::string_view method) { return method.ends_with("/stream") || method.ends_with("/breadth-first"); }

Outcome<TraceSettings> parse_trace_options(int argc, char** argv) {
  CLI::App app(kTraceDescription, "accel-trace");
  TraceSettings settings;
  RawTraceOptions raw;
  add_what(app, settings, raw);
  add_rays(app, settings, raw);
  add_measuring(app, settings, raw);
  add_outputs(app, settings, raw);
  add_build_options(app, settings.build);
  add_common_options(app, settings.common);
  app.footer(kTraceExamples);

  auto answer = parse_arguments(app, argc, argv, settings.common);
  if (!answer) return answer.failure();
  settings.help = *answer;
  settings.is_demo = app.count("SCENE") == 0;
  settings.check_given = app.count("--check") > 0;
  settings.build.threads = settings.common.threads;
  keep_hit_options(app, settings);
  if (!settings.help.empty() || settings.list) return settings;
  if (auto done = refuse_build_options(app, settings); !done) return done.failure();
  if (settings.sweep) apply_sweep_defaults(app, settings, raw);
  if (auto done = interpret(raw, settings); !done) return done.failure();
  if (auto done = refuse_idle_options(app, settings); !done) return done.failure();
  if (auto done = check_consistency(settings); !done) return done.failure();
  return settings;
}

}  // namespace accel::apps
