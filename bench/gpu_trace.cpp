// Rays per second on a CUDA device: every method x ray kind x launch policy, each answer compared with the CPU's bit for bit.
// Packets have one more, "queues": persistent, with localized intersection by packet/localized_warp.h.
//
//   gpu_trace [--scene builtin:NAME[:size] | FILE]... [--rays FILE.npy]... [--size N] [--test NAME] [--repeat N] [--json
//   FILE|-]
//
// Image kinds have N x N pixels (default 2048, 4.2 million rays), the others as many rays. Rays from files are traced in every
// scene. Times are of the kernel alone, between two events on the device: warm-up launches first, then the median of the timed
// ones. The table goes to stdout, messages to stderr; the JSON has Google Benchmark's shape.
//
// Brute force takes a prefix of the rays: as many as make kMaxExhaustiveTests triangle tests.
//
// Exit status: 0 ok, 1 error, 2 usage, 3 a device answer differs from the CPU's, 5 no device or built without CUDA.
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "libaccel/accel.h"
#include "libaccel/exec/cuda/device_accel.h"
#include "libaccel/rays/default_light.h"
#include "scenes/procedural.h"

namespace {

using namespace accel;
using Json = nlohmann::ordered_json;

enum ExitStatus { kOk = 0, kFailed = 1, kUsage = 2, kMismatch = 3, kNoDevice = 5 };

constexpr std::uint64_t kMaxExhaustiveTests = 1ull << 33;
constexpr int kWarmUp = 3;

struct Arguments {
  std::vector<std::string> scenes, ray_files;
  std::uint32_t size = 2048;
  int repeat = 11;
  std::string test, json;
};

struct NamedRays {
  std::string kind;
  Query query;
  Buffer<Ray> rays;
};

// How rays are launched.
struct NamedPolicy {
  const char* name;
  LaunchPolicy policy;
  bool packet_queues = false;
};
constexpr NamedPolicy kPolicies[] = {{policy_name(LaunchPolicy::grid), LaunchPolicy::grid},
                                     {policy_name(LaunchPolicy::persistent), LaunchPolicy::persistent},
                                     {policy_name(LaunchPolicy::multipass), LaunchPolicy::multipass},
                                     {"queues", LaunchPolicy::persistent, true}};

struct Row {
  std::string scene, method, kind;
  const char* policy;
  std::uint64_t rays, mismatches, bytes;
  DeviceTiming timing;

  double mrays(float ms) const { return static_cast<double>(rays) / (static_cast<double>(ms) * 1e3); }
};

int usage(std::string_view problem) {
  std::cerr << "error: " << problem
            << "\nusage: gpu_trace [--scene builtin:NAME[:size] | FILE]... [--rays FILE.npy]... [--size N] [--test NAME]"
               " [--repeat N] [--json FILE|-]\n";
  return kUsage;
}

template <class T>
bool parse_number(std::string_view text, T& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() && value > 0;
}

// Empty, or what is wrong.
std::string parse(int argc, char** argv, Arguments& arguments) {
  for (int i = 1; i < argc; i += 2) {
    const std::string_view flag = argv[i];
    if (i + 1 == argc) return std::string(flag) + " needs a value";
    const std::string value = argv[i + 1];
    if (flag == "--scene")
      arguments.scenes.push_back(value);
    else if (flag == "--rays")
      arguments.ray_files.push_back(value);
    else if (flag == "--test")
      arguments.test = value;
    else if (flag == "--json")
      arguments.json = value;
    else if (flag == "--size" && parse_number(value, arguments.size))
      continue;
    else if (flag == "--repeat" && parse_number(value, arguments.repeat))
      continue;
    else
      return "unknown option or bad value: " + std::string(flag) + " " + value;
  }
  if (arguments.scenes.empty()) arguments.scenes = {"builtin:stadium", "builtin:hairball", "builtin:colonnade"};
  return {};
}

// JSON on standard output has that for itself.
std::FILE* table_of(const Arguments& arguments) { return arguments.json == "-" ? stderr : stdout; }

// With its cameras and light, as one mesh.
Result<SceneData> open_scene(const std::string& name) {
  auto scene = name.starts_with("builtin:") ? make_builtin(name) : load_scene(name);
  if (!scene) return scene;
  auto mesh = scene->one_mesh();
  if (!mesh) return mesh.error();
  scene->mesh = *std::move(mesh);
  return scene;
}

// One set of each kind that the library makes.
Result<std::vector<NamedRays>> make_ray_sets(const SceneData& scene, const AnyAccel& accel, std::uint32_t size) {
  const Aabb bounds = mesh_facts(scene.mesh).bounds;
  const CameraDescription view = scene.cameras.empty() ? default_camera(bounds) : scene.cameras.front();
  const LightDescription light = scene.light.value_or(default_light(bounds, view));
  const auto camera = Camera::make(view, size, size);
  if (!camera) return camera.error();
  const auto primary = primary_rays(*camera, 1, 1, PixelOrder::z_curve);
  if (!primary) return primary.error();
  std::vector<Hit> hits(primary->size());
  if (const Status s = accel.closest(primary->rays.span(), hits); !s) return s.error();

  const std::uint64_t count = std::uint64_t{size} * size;
  const PrimaryHits from{scene.mesh, *primary, hits};
  std::vector<NamedRays> sets;
  for (const RayKindInfo& kind : ray_kinds()) {
    if (kind.kind == RayKind::soft_shadow) continue;  // sixteen times the rays of shadow, and no other pattern
    const auto set = kind.kind == RayKind::primary  ? primary
                     : kind.kind == RayKind::random ? random_rays(bounds, count)
                     : kind.kind == RayKind::edge   ? edge_rays(scene.mesh, count)
                                                    : secondary_rays(kind.kind, from, light);
    if (!set) return set.error();
    sets.push_back({std::string(kind.name), kind.query, set->rays});
  }
  return sets;
}

std::uint64_t ray_limit(const MethodInfo& method, const TriangleMesh& mesh) {
  if (!method.exhaustive) return DeviceBatch::kMaxRays;
  return std::max<std::uint64_t>(1024, kMaxExhaustiveTests / std::max<std::uint64_t>(mesh.size(), 1));
}

template <class T>
std::uint64_t differences(const std::vector<T>& a, const std::vector<T>& b) {
  std::uint64_t count = 0;
  for (std::size_t i = 0; i < a.size(); ++i) count += std::memcmp(&a[i], &b[i], sizeof(T)) != 0;
  return count;
}

// How many answers of the last trace differ from the CPU's.
Result<std::uint64_t> count_mismatches(const AnyAccel& cpu, const DeviceBatch& batch, std::span<const Ray> rays, Query query,
                                       const std::string& test) {
  if (query == Query::closest) {
    std::vector<Hit> expected(rays.size()), actual(rays.size());
    if (const Status s = cpu.closest(rays, expected, {.test = test}); !s) return s.error();
    if (const Status s = batch.hits(actual); !s) return s.error();
    return differences(expected, actual);
  }
  std::vector<std::uint8_t> expected(rays.size()), actual(rays.size());
  if (const Status s = cpu.occluded(rays, expected, {.test = test}); !s) return s.error();
  if (const Status s = batch.occluded(actual); !s) return s.error();
  return differences(expected, actual);
}

// All launch policies of one method on one set of rays.
Status measure(const Arguments& arguments, const AnyAccel& cpu, const DeviceAccel& device, const NamedRays& set,
               std::span<const Ray> rays, Row row, std::vector<Row>& rows) {
  const auto batch = DeviceBatch::upload(rays);
  if (!batch) return batch.error();
  row.kind = set.kind, row.rays = rays.size(), row.bytes = device.size_bytes();
  const bool makes_packets = row.method.ends_with("/breadth-first");
  for (const NamedPolicy& policy : kPolicies) {
    if (policy.packet_queues && !makes_packets) continue;
    const DeviceTraceOptions options{.policy = policy.policy,
                                     .test = arguments.test,
                                     .warm_up = kWarmUp,
                                     .repeat = arguments.repeat,
                                     .packet_queues = policy.packet_queues};
    const auto timing = device.trace(*batch, set.query, options);
    if (!timing) return timing.error();
    const auto mismatches = count_mismatches(cpu, *batch, rays, set.query, arguments.test);
    if (!mismatches) return mismatches.error();
    row.policy = policy.name, row.timing = *timing, row.mismatches = *mismatches;
    rows.push_back(row);
    std::fprintf(table_of(arguments), "%-20.20s %-12s %-9s %-10s %9.1f %9.1f %9.1f %8llu %6llu\n", row.scene.c_str(),
                 row.method.c_str(), row.kind.c_str(), row.policy, row.mrays(timing->median_ms), row.mrays(timing->max_ms),
                 row.mrays(timing->min_ms), static_cast<unsigned long long>(row.rays),
                 static_cast<unsigned long long>(row.mismatches));
    std::fflush(table_of(arguments));
  }
  return Done{};
}

Status measure_scene(const Arguments& arguments, const std::string& name, std::vector<Row>& rows) {
  const auto scene = open_scene(name);
  if (!scene) return scene.error();
  const auto best = AnyAccel::build(scene->mesh, best_method());
  if (!best) return best.error();
  auto sets = make_ray_sets(*scene, *best, arguments.size);
  if (!sets) return sets.error();
  for (const std::string& file : arguments.ray_files) {
    auto rays = read_rays_npy(file);
    if (!rays) return rays.error();
    sets->push_back({file.substr(file.find_last_of('/') + 1), Query::closest, std::move(*rays)});
  }
  for (const MethodInfo& method : methods()) {
    const auto cpu = AnyAccel::build(scene->mesh, method.name);
    if (!cpu) return cpu.error();
    const auto device = DeviceAccel::upload(cpu->structure(), method.name);
    if (!device) return device.error();
    for (const NamedRays& set : *sets) {
      const std::size_t count = std::min<std::uint64_t>(set.rays.size(), ray_limit(method, scene->mesh));
      if (count == 0) continue;
      const Row row{.scene = name, .method = method.name};
      if (const Status s = measure(arguments, *cpu, *device, set, set.rays.span().first(count), row, rows); !s) return s;
    }
  }
  return Done{};
}

Json to_json(const Row& row, const Arguments& arguments) {
  const auto ms = static_cast<double>(row.timing.median_ms);
  return {{"name", row.scene + "/" + row.method + "/" + row.kind + "/" + row.policy},
          {"run_type", "iteration"},
          {"iterations", arguments.repeat},
          {"real_time", ms},
          {"cpu_time", ms},
          {"time_unit", "ms"},
          {"scene", row.scene},
          {"method", row.method},
          {"test", arguments.test.empty() ? triangle_tests().front() : arguments.test},
          {"rays_kind", row.kind},
          {"policy", row.policy},
          {"rays", row.rays},
          {"mrays_per_second", row.mrays(row.timing.median_ms)},
          {"mrays_min", row.mrays(row.timing.max_ms)},
          {"mrays_max", row.mrays(row.timing.min_ms)},
          {"mismatches", row.mismatches},
          {"bytes", row.bytes}};
}

bool write_json(const Arguments& arguments, const DeviceInfo& device, const std::vector<Row>& rows) {
  Json json;
  json["context"] = {{"library_version", kVersion},
                     {"device", device.name},
                     {"compute_capability", std::to_string(device.compute_major) + "." + std::to_string(device.compute_minor)},
                     {"multiprocessors", device.multiprocessors},
                     {"cuda_runtime", device.runtime_version},
                     {"cuda_driver", device.driver_version}};
  json["benchmarks"] = Json::array();
  for (const Row& row : rows) json["benchmarks"].push_back(to_json(row, arguments));
  if (arguments.json == "-") return static_cast<bool>(std::cout << json.dump(2) << '\n');
  return static_cast<bool>(std::ofstream(arguments.json) << json.dump(2) << '\n');
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  if (const std::string problem = parse(argc, argv, arguments); !problem.empty()) return usage(problem);
  const auto device = cuda_device_info();
  if (!device) {
    std::cerr << "error: " << device.message() << '\n';
    return kNoDevice;
  }
  std::fprintf(table_of(arguments), "%s, compute capability %d.%d, %d multiprocessors\n", device->name.c_str(),
               device->compute_major, device->compute_minor, device->multiprocessors);
  std::fprintf(table_of(arguments), "%-20s %-12s %-9s %-10s %9s %9s %9s %8s %6s\n", "scene", "method", "rays", "policy",
               "Mrays/s", "min", "max", "count", "differ");
  std::vector<Row> rows;
  for (const std::string& scene : arguments.scenes) {
    if (const Status s = measure_scene(arguments, scene, rows); !s) {
      std::cerr << "error: " << s.message() << '\n';
      return kFailed;
    }
  }
  if (!arguments.json.empty() && !write_json(arguments, *device, rows)) {
    std::cerr << "error: cannot write " << arguments.json << '\n';
    return kFailed;
  }
  const bool all_equal = std::all_of(rows.begin(), rows.end(), [](const Row& row) { return row.mismatches == 0; });
  return all_equal ? kOk : kMismatch;
}
