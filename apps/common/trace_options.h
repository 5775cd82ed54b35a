// The command line of accel-trace.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/common/common_settings.h"
#include "libaccel/build/builder.h"
#include "libaccel/exec/counters.h"
#include "libaccel/exec/multipass_profile.h"
#include "libaccel/exec/simt_profile.h"
#include "libaccel/packet/packet_options.h"
#include "libaccel/packet/ray_order.h"
#include "libaccel/rays/ray_sets.h"

namespace accel::apps {

enum class Check { embree, exact, none };

struct TraceSettings {
  CommonSettings common;
  std::string help;  // what --help or --version asked for; then nothing else is set
  bool list = false;

  std::string scene = "builtin:stadium";
  std::string camera;                  // a name, a number or ten numbers; empty: the scene's first, or derived
  std::vector<std::string> methods;    // names, or "all"
  std::vector<std::string> ray_kinds;  // names, or .npy files
  std::optional<Query> query;          // asked of all rays; else what renderers ask of their kind, closest hits of files
  std::string test;                    // a triangle test; empty: the first
  std::string device = "cpu";
  BuildOptions build;

  std::uint32_t width = 1024, height = 768, spp = 1;
  PixelOrder pixel_order = PixelOrder::rows;
  std::uint64_t count = 0;  // 0: width * height
  int repeat = 5;

  Check check = Check::embree;
  bool check_given = false;
  std::vector<std::string> embree;  // modes to be timed besides the fast one, or "all"; empty: that one, if it is the witness
  std::uint64_t judge_limit = 0;    // 0: none

  bool sweep = false;               // every combination of method and triangle test: see apps/common/sweep.h
  std::optional<double> max_error;  // wrong hits per million that advice allows

  std::vector<std::string> scaling;  // sizes of the built-in scene, as in its name: "10k"

  std::optional<RaySort> sort;  // measure sorted rays, too
  PacketOptions packets;        // its cell_fraction is that of the sort, too

  bool profile_simt = false, profile_multipass = false;
  SimtSchedule schedule = SimtSchedule::while_while;
  MultipassOptions multipass;

  bool explain = false;  // what builds left out, and why

  // Output files; empty: none.
  std::string json, report, image, heatmap, diff, rays_out, hits_out;
  std::uint32_t hits = 0;  // a ray, in hits_out; 0: one, as the method traces it
  RayCounter heatmap_of = RayCounter::steps;
  std::string repro = "accel-repro";  // how the names of repro bundles begin

  bool is_demo = false;  // no scene was named
  // Those given that decide hits, but for scene, method, test and rays, as arguments; and those of methods that make packets.
  std::vector<std::string> hit_options, packet_options;
};

// Whether a method traces batches as packets.
bool makes_packets(std::string_view method);

// Errors are usage errors; names of methods, ray kinds and tests are looked up here.
Outcome<TraceSettings> parse_trace_options(int argc, char** argv);

}  // namespace accel::apps
