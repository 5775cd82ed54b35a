#include "validation/oracle/embree.h"

#if defined(ACCEL_HAVE_EMBREE)

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstring>
#include <type_traits>

#include "libaccel/core/affine.h"
#include "libaccel/core/buffer.h"
#include "libaccel/exec/cpu.h"
#include "libaccel/trace/multi_hit.h"

namespace accel::validation {

namespace {

// The rays that Embree takes, which aborts where one leaves its range in the space of an instance.
class Takes {
 public:
  // Of an instance more.
  void add(const AffineInverse& map) {
    maps_.push_back(map);
    double scale = 0, reach = 0;
    for (int i = 0; i < 3; ++i) {
      double row = 0;
      for (int j = 0; j < 3; ++j) row += std::fabs(map.linear[i][j]);
      scale = std::max(scale, row), reach = std::max(reach, std::fabs(double{map.origin[i]}));
    }
    // Half, for Embree inverts and rounds by itself.
    const double most = 0.5 * kMaxCoordinate / std::max(scale, 0.5);
    most_dir_ = std::min(most_dir_, static_cast<float>(most));
    most_org_ = std::min(most_org_, static_cast<float>(std::max(most - reach, 0.0)));
  }

  bool operator()(const Ray& ray) const {
    if (!is_traceable(ray)) return false;
    if (maps_.empty() || (is_within(ray.dir, most_dir_) && is_within(ray.org, most_org_))) return true;
    return std::all_of(maps_.begin(), maps_.end(), [&](const AffineInverse& map) {
      const Ray inside = map.ray(ray);
      return is_within(inside.dir, 0.5f * kMaxCoordinate) && is_within(inside.org, 0.5f * kMaxCoordinate);
    });
  }

 private:
  static bool is_within(Vec3 v, float most) {
    return std::fabs(v.x) <= most && std::fabs(v.y) <= most && std::fabs(v.z) <= most;
  }

  std::vector<AffineInverse> maps_;
  float most_dir_ = kMaxCoordinate, most_org_ = kMaxCoordinate;
};

}  // namespace

struct EmbreeWitness::Scene {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  std::vector<RTCScene> meshes;            // of instances
  std::vector<std::uint32_t> first_prims;  // likewise: by instance
  Takes takes;
  EmbreeOptions options;
  std::string isa;
  double build_seconds = 0;
  std::atomic<std::int64_t> bytes{0};

  ~Scene() {
    if (scene != nullptr) rtcReleaseScene(scene);
    for (const RTCScene mesh : meshes) rtcReleaseScene(mesh);
    if (device != nullptr) rtcReleaseDevice(device);
  }
};

namespace {

std::string widest_isa() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl")) return "avx512";
  if (__builtin_cpu_supports("avx2")) return "avx2";
  return "sse4.2";
#else
  return "";
#endif
}

bool count_bytes(void* counter, ssize_t bytes, bool /*after*/) {
  static_cast<std::atomic<std::int64_t>*>(counter)->fetch_add(bytes, std::memory_order_relaxed);
  return true;
}

Error device_error(RTCDevice device, const char* what) {
  return Error{std::string("Embree could not ") + what + " (error code " + std::to_string(rtcGetDeviceError(device)) + ")"};
}

RTCBuildQuality quality_of(EmbreeQuality quality) {
  switch (quality) {
    case EmbreeQuality::low:
      return RTC_BUILD_QUALITY_LOW;
    case EmbreeQuality::medium:
      return RTC_BUILD_QUALITY_MEDIUM;
    case EmbreeQuality::high:
      return RTC_BUILD_QUALITY_HIGH;
  }
  return RTC_BUILD_QUALITY_MEDIUM;
}

RTCSceneFlags flags_of(const EmbreeOptions& options) {
#if RTC_VERSION_MAJOR >= 4
  constexpr int kFilterPerQuery = RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS;
#else
  constexpr int kFilterPerQuery = RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION;
#endif
  return static_cast<RTCSceneFlags>((options.mode == EmbreeMode::robust ? RTC_SCENE_FLAG_ROBUST : 0) |
                                    (options.all_hits ? kFilterPerQuery : 0));
}

Status attach_mesh(RTCDevice device, RTCScene scene, const TriangleMesh& mesh, RTCBuildQuality quality) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  // Embree owns the copies: it pads them for its 16-byte loads.
  void* vertices =
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Vec3), mesh.vertices.size());
  void* triangles =
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(IndexTriple), mesh.size());
  if (vertices == nullptr || triangles == nullptr) {
    rtcReleaseGeometry(geometry);
    return device_error(device, "allocate its copy of the mesh");
  }
  std::memcpy(vertices, mesh.vertices.data(), mesh.vertices.size_bytes());
  std::memcpy(triangles, mesh.triangles.data(), mesh.triangles.size_bytes());
  rtcSetGeometryBuildQuality(geometry, quality);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  return Done{};
}

RTCRay to_embree(const Ray& ray) {
  RTCRay r{};
  r.org_x = ray.org.x, r.org_y = ray.org.y, r.org_z = ray.org.z, r.tnear = max_of(ray.t_min, 0.0f);
  r.dir_x = ray.dir.x, r.dir_y = ray.dir.y, r.dir_z = ray.dir.z, r.tfar = ray.t_max;
  r.mask = 0xffffffffu;
  return r;
}

// The scene of a mesh that instances refer to.
Result<RTCScene> make_mesh_scene(RTCDevice device, const TriangleMesh& mesh, const EmbreeOptions& options) {
  RTCScene scene = rtcNewScene(device);
  rtcSetSceneFlags(scene, flags_of(options));
  rtcSetSceneBuildQuality(scene, quality_of(options.quality));
  if (mesh.size() > 0)
    if (const Status attached = attach_mesh(device, scene, mesh, quality_of(options.quality)); !attached) {
      rtcReleaseScene(scene);
      return attached.error();
    }
  rtcCommitScene(scene);
  return scene;
}

// Its number among the geometries of the scene is that of the instance.
void attach_instance(RTCDevice device, RTCScene scene, RTCScene mesh, const Affine& transform) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(geometry, mesh);
  rtcSetGeometryTimeStepCount(geometry, 1);
  rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, &transform.m[0][0]);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
}

Hit intersect(RTCScene scene, const Takes& takes, std::span<const std::uint32_t> first_prims, const Ray& ray) {
  if (!takes(ray)) return {};
  RTCRayHit query{};
  query.ray = to_embree(ray);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
  rtcIntersect1(scene, &query);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, &query);
#endif
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
  const std::uint32_t first_prim = first_prims.empty() ? 0 : first_prims[query.hit.instID[0]];
  return {query.ray.tfar, query.hit.u, query.hit.v, first_prim + query.hit.primID};
}

bool is_occluded(RTCScene scene, const Takes& takes, const Ray& ray) {
  if (!takes(ray)) return false;
  RTCRay query = to_embree(ray);
#if RTC_VERSION_MAJOR >= 4
  rtcOccluded1(scene, &query);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene, &context, &query);
#endif
  return query.tfar < 0;
}

// What a query for all hits hands to its filter function: Embree's context, and behind it what it does not know.
#if RTC_VERSION_MAJOR >= 4
using EmbreeContext = RTCRayQueryContext;
#else
using EmbreeContext = RTCIntersectContext;
#endif
struct KeepAll {
  EmbreeContext context;
  std::span<const std::uint32_t> first_prims;
  std::vector<Hit>* hits;
};

// Keeps a hit, and refuses it, so that the query goes on.
void keep_and_refuse(const RTCFilterFunctionNArguments* arguments) {
  const KeepAll& keep = *reinterpret_cast<const KeepAll*>(arguments->context);
  RTCHitN* const hit = arguments->hit;
  const unsigned n = arguments->N;
  const std::uint32_t first_prim = keep.first_prims.empty() ? 0 : keep.first_prims[RTCHitN_instID(hit, n, 0, 0)];
  keep.hits->push_back(
      {RTCRayN_tfar(arguments->ray, n, 0), RTCHitN_u(hit, n, 0), RTCHitN_v(hit, n, 0), first_prim + RTCHitN_primID(hit, n, 0)});
  arguments->valid[0] = 0;
}

void offer_all(RTCScene scene, KeepAll& keep, RTCRayHit& query) {
#if RTC_VERSION_MAJOR >= 4
  rtcInitRayQueryContext(&keep.context);
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.context = &keep.context, arguments.filter = keep_and_refuse;
  arguments.flags = static_cast<RTCRayQueryFlags>(arguments.flags | RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER);
  rtcIntersect1(scene, &query, &arguments);
#else
  rtcInitIntersectContext(&keep.context);
  keep.context.filter = keep_and_refuse;
  rtcIntersect1(scene, &keep.context, &query);
#endif
}

std::vector<Hit> all_hits_of(RTCScene scene, const Takes& takes, std::span<const std::uint32_t> first_prims, const Ray& ray) {
  std::vector<Hit> hits;
  if (!takes(ray)) return hits;
  KeepAll keep{{}, first_prims, &hits};
  RTCRayHit query{};
  query.ray = to_embree(ray);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  offer_all(scene, keep, query);
  // A triangle that Embree has split may be offered more than once.
  std::sort(hits.begin(), hits.end(), [](const Hit& a, const Hit& b) { return a.prim_id < b.prim_id; });
  const auto is_same = [](const Hit& a, const Hit& b) { return a.prim_id == b.prim_id; };
  hits.erase(std::unique(hits.begin(), hits.end(), is_same), hits.end());
  std::sort(hits.begin(), hits.end(), [](const Hit& a, const Hit& b) { return is_before(place_of(a), place_of(b)); });
  return hits;
}

// What the versions call differently: Embree 4 has no streams, and its queries take no context.
#if RTC_VERSION_MAJOR >= 4
constexpr bool kHasStreams = false;
struct Caller {
  RTCScene scene;

  void intersect(const int* valid, RTCRayHit8* packet) { rtcIntersect8(valid, scene, packet); }
  void intersect(const int* valid, RTCRayHit16* packet) { rtcIntersect16(valid, scene, packet); }
  void occluded(const int* valid, RTCRay8* packet) { rtcOccluded8(valid, scene, packet); }
  void occluded(const int* valid, RTCRay16* packet) { rtcOccluded16(valid, scene, packet); }
  void intersect_stream(void*, unsigned, unsigned, std::size_t) {}
  void occluded_stream(void*, unsigned, unsigned, std::size_t) {}
};
#else
constexpr bool kHasStreams = true;
struct Caller {
  RTCScene scene;
  RTCIntersectContext context;

  explicit Caller(RTCScene of) : scene(of) { rtcInitIntersectContext(&context); }

  void intersect(const int* valid, RTCRayHit8* packet) { rtcIntersect8(valid, scene, &context, packet); }
  void intersect(const int* valid, RTCRayHit16* packet) { rtcIntersect16(valid, scene, &context, packet); }
  void occluded(const int* valid, RTCRay8* packet) { rtcOccluded8(valid, scene, &context, packet); }
  void occluded(const int* valid, RTCRay16* packet) { rtcOccluded16(valid, scene, &context, packet); }
  void intersect_stream(void* packets, unsigned width, unsigned count, std::size_t stride) {
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcIntersectNM(scene, &context, static_cast<RTCRayHitN*>(packets), width, count, stride);
  }
  void occluded_stream(void* packets, unsigned width, unsigned count, std::size_t stride) {
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcOccludedNM(scene, &context, static_cast<RTCRayN*>(packets), width, count, stride);
  }
};
#endif

// Rays in packets, structures of arrays: RTCRayHit8 of closest-hit queries, RTCRay8 of any-hit ones, or as wide as asked for.
// Rays that Embree must not see, and the places behind the last ray, have an empty interval and are not valid.
class Packets {
 public:
  Packets(Query query, unsigned width, std::size_t most_rays)
      : width_(width),
        has_hits_(query == Query::closest),
        floats_(width * (has_hits_ ? sizeof(RTCRayHit8) : sizeof(RTCRay8)) / (8 * sizeof(float))),
        memory_(packets_of(most_rays) * floats_),
        valid_(packets_of(most_rays) * width) {}

  std::size_t packets_of(std::size_t rays) const { return (rays + width_ - 1) / width_; }
  unsigned width() const { return width_; }
  std::size_t stride() const { return floats_ * sizeof(float); }
  float* packet(std::size_t p) { return memory_.data() + p * floats_; }
  const int* valid(std::size_t p) const { return valid_.data() + p * width_; }

  void fill(const Takes& takes, std::span<const Ray> rays) {
    for (std::size_t i = 0; i < packets_of(rays.size()) * width_; ++i) {
      const bool traced = i < rays.size() && takes(rays[i]);
      valid_[i] = traced ? -1 : 0;
      put(i, traced ? to_embree(rays[i]) : nothing());
    }
  }

  void read(std::span<const std::uint32_t> first_prims, std::span<Hit> hits) {
    for (std::size_t i = 0; i < hits.size(); ++i) {
      float* const at = packet(i / width_);
      const unsigned lane = static_cast<unsigned>(i % width_);
      RTCHitN* const hit = RTCRayHitN_HitN(reinterpret_cast<RTCRayHitN*>(at), width_);
      hits[i] = {};
      if (RTCHitN_geomID(hit, width_, lane) == RTC_INVALID_GEOMETRY_ID) continue;
      const std::uint32_t first_prim = first_prims.empty() ? 0 : first_prims[RTCHitN_instID(hit, width_, lane, 0)];
      hits[i] = {RTCRayN_tfar(reinterpret_cast<RTCRayN*>(at), width_, lane), RTCHitN_u(hit, width_, lane),
                 RTCHitN_v(hit, width_, lane), first_prim + RTCHitN_primID(hit, width_, lane)};
    }
  }

  void read(std::span<const std::uint32_t> /*first_prims*/, std::span<std::uint8_t> occluded) {
    for (std::size_t i = 0; i < occluded.size(); ++i) {
      RTCRayN* const ray = reinterpret_cast<RTCRayN*>(packet(i / width_));
      occluded[i] = RTCRayN_tfar(ray, width_, static_cast<unsigned>(i % width_)) < 0 ? 1 : 0;
    }
  }

 private:
  static RTCRay nothing() {
    RTCRay r{};
    r.dir_z = 1, r.tnear = 1, r.tfar = 0;
    return r;
  }

  void put(std::size_t i, const RTCRay& from) {
    float* const at = packet(i / width_);
    const unsigned lane = static_cast<unsigned>(i % width_);
    RTCRayN* const ray = reinterpret_cast<RTCRayN*>(at);
    RTCRayN_org_x(ray, width_, lane) = from.org_x, RTCRayN_dir_x(ray, width_, lane) = from.dir_x;
    RTCRayN_org_y(ray, width_, lane) = from.org_y, RTCRayN_dir_y(ray, width_, lane) = from.dir_y;
    RTCRayN_org_z(ray, width_, lane) = from.org_z, RTCRayN_dir_z(ray, width_, lane) = from.dir_z;
    RTCRayN_tnear(ray, width_, lane) = from.tnear, RTCRayN_tfar(ray, width_, lane) = from.tfar;
    RTCRayN_time(ray, width_, lane) = from.time, RTCRayN_mask(ray, width_, lane) = from.mask;
    RTCRayN_id(ray, width_, lane) = from.id, RTCRayN_flags(ray, width_, lane) = from.flags;
    if (!has_hits_) return;
    RTCHitN* const hit = RTCRayHitN_HitN(reinterpret_cast<RTCRayHitN*>(at), width_);
    RTCHitN_geomID(hit, width_, lane) = RTC_INVALID_GEOMETRY_ID;
    RTCHitN_instID(hit, width_, lane, 0) = RTC_INVALID_GEOMETRY_ID;
  }

  unsigned width_;
  bool has_hits_;
  std::size_t floats_;  // of a packet
  Buffer<float> memory_;
  Buffer<int> valid_;
};

// Streams are fastest in packets of the width that Embree's instructions have.
unsigned width_of(EmbreeCalls calls, RTCDevice device) {
  if (calls == EmbreeCalls::packets8) return 8;
  if (calls == EmbreeCalls::packets16) return 16;
  if (rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED) != 0) return 16;
  return rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED) != 0 ? 8 : 4;
}

void call_stream(Caller& caller, Query query, Packets& packets, std::size_t begin, std::size_t end) {
  const auto count = static_cast<unsigned>(end - begin);
  if (query == Query::closest)
    caller.intersect_stream(packets.packet(begin), packets.width(), count, packets.stride());
  else
    caller.occluded_stream(packets.packet(begin), packets.width(), count, packets.stride());
}

template <class RayHitPacket, class RayPacket>
void call_packet(Caller& caller, Query query, Packets& packets, std::size_t p) {
  if (query == Query::closest)
    caller.intersect(packets.valid(p), reinterpret_cast<RayHitPacket*>(packets.packet(p)));
  else
    caller.occluded(packets.valid(p), reinterpret_cast<RayPacket*>(packets.packet(p)));
}

// Packets [begin, end).
void trace_packets(RTCScene scene, Query query, EmbreeCalls calls, Packets& packets, std::size_t begin, std::size_t end) {
  Caller caller{scene};
  const std::size_t stream = kEmbreeStreamRays / packets.width();
  switch (calls) {
    case EmbreeCalls::single:
      break;
    case EmbreeCalls::packets8:
      for (std::size_t p = begin; p < end; ++p) call_packet<RTCRayHit8, RTCRay8>(caller, query, packets, p);
      break;
    case EmbreeCalls::packets16:
      for (std::size_t p = begin; p < end; ++p) call_packet<RTCRayHit16, RTCRay16>(caller, query, packets, p);
      break;
    case EmbreeCalls::streams:
      for (std::size_t p = begin; p < end; p += stream) call_stream(caller, query, packets, p, std::min(end, p + stream));
      break;
  }
}

template <class Work>
double seconds_of(const Work& work) {
  const auto before = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
}

// In rounds that fit a cache, as an application's rays do when it traces tile after tile: for each thread, some streams.
template <class Answer>
double time_packets(RTCScene scene, const Takes& takes, EmbreeCalls calls, unsigned width,
                    std::span<const std::uint32_t> first_prims, std::span<const Ray> rays, std::span<Answer> answers,
                    int threads) {
  constexpr Query kQuery = std::is_same_v<Answer, Hit> ? Query::closest : Query::any;
  const int workers = threads > 0 ? threads : tbb::this_task_arena::max_concurrency();
  const std::size_t round = std::min(rays.size(), 8 * kEmbreeStreamRays * static_cast<std::size_t>(workers));
  Packets packets(kQuery, width, round);
  double seconds = 0;
  for (std::size_t begin = 0; begin < rays.size(); begin += round) {
    const std::size_t count = std::min(round, rays.size() - begin);
    packets.fill(takes, rays.subspan(begin, count));
    const auto trace = [&](std::size_t from, std::size_t to) { trace_packets(scene, kQuery, calls, packets, from, to); };
    seconds += seconds_of([&] { for_each_block(packets.packets_of(count), threads, trace, kEmbreeStreamRays / width); });
    packets.read(first_prims, answers.subspan(begin, count));
  }
  return seconds;
}

}  // namespace

bool EmbreeWitness::available() { return true; }

std::string EmbreeWitness::version() {
  return "Embree " + std::to_string(RTC_VERSION_MAJOR) + "." + std::to_string(RTC_VERSION_MINOR) + "." +
         std::to_string(RTC_VERSION_PATCH);
}

// A device and an empty scene.
Result<std::unique_ptr<EmbreeWitness::Scene>> EmbreeWitness::start(const EmbreeOptions& options) {
  auto owned = std::make_unique<Scene>();
  owned->options = options;
  owned->isa = widest_isa();
  std::string config = "threads=" + std::to_string(options.build_threads);
  if (!owned->isa.empty()) config += ",isa=" + owned->isa;
  owned->device = rtcNewDevice(config.c_str());
  if (owned->device == nullptr) return device_error(nullptr, "create a device");
  rtcSetDeviceMemoryMonitorFunction(owned->device, count_bytes, &owned->bytes);

  owned->scene = rtcNewScene(owned->device);
  rtcSetSceneFlags(owned->scene, flags_of(options));
  rtcSetSceneBuildQuality(owned->scene, quality_of(options.quality));
  return owned;
}

// Builds what has been attached.
Result<EmbreeWitness> EmbreeWitness::finish(std::unique_ptr<Scene> owned) {
  const auto before = std::chrono::steady_clock::now();
  rtcCommitScene(owned->scene);
  owned->build_seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
  if (rtcGetDeviceError(owned->device) != RTC_ERROR_NONE) return device_error(owned->device, "build the scene");
  return EmbreeWitness(std::move(owned));
}

Result<EmbreeWitness> EmbreeWitness::build(const TriangleMesh& mesh, const EmbreeOptions& options) {
  Result<std::unique_ptr<Scene>> owned = start(options);
  if (!owned) return owned.error();
  Scene& scene = **owned;
  if (mesh.size() > 0) {
    const Status attached = attach_mesh(scene.device, scene.scene, mesh, quality_of(options.quality));
    if (!attached) return attached.error();
  }
  return finish(*std::move(owned));
}

Result<EmbreeWitness> EmbreeWitness::build(const InstancedMeshes& instanced, const EmbreeOptions& options) {
  Result<std::unique_ptr<Scene>> owned = start(options);
  if (!owned) return owned.error();
  Scene& scene = **owned;
  const auto before = std::chrono::steady_clock::now();
  for (const TriangleMesh& mesh : instanced.meshes()) {
    const Result<RTCScene> made = make_mesh_scene(scene.device, mesh, options);
    if (!made) return made.error();
    scene.meshes.push_back(*made);
  }
  scene.build_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
  for (std::size_t i = 0; i < instanced.instances().size(); ++i) {
    const Instance& instance = instanced.instances()[i];
    attach_instance(scene.device, scene.scene, scene.meshes[instance.mesh], instance.transform);
    scene.first_prims.push_back(instanced.first_prim(i));
    scene.takes.add(*inverse(instance.transform));
  }
  return finish(*std::move(owned));
}

Status EmbreeWitness::move_instances(std::span<const Instance> instances) {
  if (instances.size() != scene_->first_prims.size()) return Error{"there are other instances than were built"};
  scene_->takes = {};
  for (unsigned i = 0; i < instances.size(); ++i) {
    const RTCGeometry geometry = rtcGetGeometry(scene_->scene, i);
    rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, &instances[i].transform.m[0][0]);
    rtcCommitGeometry(geometry);
    scene_->takes.add(*inverse(instances[i].transform));
  }
  rtcCommitScene(scene_->scene);
  if (rtcGetDeviceError(scene_->device) != RTC_ERROR_NONE) return device_error(scene_->device, "move the instances");
  return Done{};
}

void EmbreeWitness::closest(std::span<const Ray> rays, std::span<Hit> hits, int threads) const {
  for_each_block(rays.size(), threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) hits[i] = intersect(scene_->scene, scene_->takes, scene_->first_prims, rays[i]);
  });
}

void EmbreeWitness::occluded(std::span<const Ray> rays, std::span<std::uint8_t> occluded, int threads) const {
  for_each_block(rays.size(), threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) occluded[i] = is_occluded(scene_->scene, scene_->takes, rays[i]) ? 1 : 0;
  });
}

Status EmbreeWitness::can(EmbreeCalls calls) const {
  if (calls != EmbreeCalls::streams) return Done{};
  if (!kHasStreams) return Error{version() + " has no streams of rays; Embree 3 has"};
  // Seen in Embree 3.13.5: rtcOccludedNM, flagged coherent, loops for ever.
  if (!scene_->meshes.empty()) return Error{"Embree's coherent streams may never return from scenes with instances"};
  return Done{};
}

Result<double> EmbreeWitness::time_closest(EmbreeCalls calls, std::span<const Ray> rays, std::span<Hit> hits,
                                           int threads) const {
  if (const Status possible = can(calls); !possible) return possible.error();
  if (calls == EmbreeCalls::single) return seconds_of([&] { closest(rays, hits, threads); });
  return time_packets(scene_->scene, scene_->takes, calls, width_of(calls, scene_->device), scene_->first_prims, rays, hits,
                      threads);
}

Result<double> EmbreeWitness::time_occluded(EmbreeCalls calls, std::span<const Ray> rays, std::span<std::uint8_t> occluded,
                                            int threads) const {
  if (const Status possible = can(calls); !possible) return possible.error();
  if (calls == EmbreeCalls::single) return seconds_of([&] { this->occluded(rays, occluded, threads); });
  return time_packets(scene_->scene, scene_->takes, calls, width_of(calls, scene_->device), scene_->first_prims, rays, occluded,
                      threads);
}

void EmbreeWitness::all_hits(std::span<const Ray> rays, std::span<std::vector<Hit>> hits, int threads) const {
  ACCEL_ASSERT(scene_->options.all_hits);
  for_each_block(rays.size(), threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) hits[i] = all_hits_of(scene_->scene, scene_->takes, scene_->first_prims, rays[i]);
  });
}

double EmbreeWitness::build_seconds() const { return scene_->build_seconds; }
std::size_t EmbreeWitness::size_bytes() const { return static_cast<std::size_t>(scene_->bytes.load()); }
const std::string& EmbreeWitness::isa() const { return scene_->isa; }
const EmbreeOptions& EmbreeWitness::options() const { return scene_->options; }

}  // namespace accel::validation

#else

namespace accel::validation {

namespace {
const std::string kNoIsa;
const EmbreeOptions kNoOptions;
}  // namespace

struct EmbreeWitness::Scene {};

bool EmbreeWitness::available() { return false; }
std::string EmbreeWitness::version() { return "Embree: not built in (ACCEL_WITH_EMBREE)"; }
Result<std::unique_ptr<EmbreeWitness::Scene>> EmbreeWitness::start(const EmbreeOptions&) {
  return Error{"this program was built without Embree; configure with ACCEL_WITH_EMBREE=ON, or check with --check exact"};
}
Result<EmbreeWitness> EmbreeWitness::finish(std::unique_ptr<Scene>) { return start({}).error(); }
Result<EmbreeWitness> EmbreeWitness::build(const TriangleMesh&, const EmbreeOptions&) { return start({}).error(); }
Result<EmbreeWitness> EmbreeWitness::build(const InstancedMeshes&, const EmbreeOptions&) { return start({}).error(); }
Status EmbreeWitness::move_instances(std::span<const Instance>) { return start({}).error(); }
void EmbreeWitness::closest(std::span<const Ray>, std::span<Hit>, int) const {}
void EmbreeWitness::occluded(std::span<const Ray>, std::span<std::uint8_t>, int) const {}
Status EmbreeWitness::can(EmbreeCalls) const { return start({}).error(); }
Result<double> EmbreeWitness::time_closest(EmbreeCalls, std::span<const Ray>, std::span<Hit>, int) const {
  return start({}).error();
}
Result<double> EmbreeWitness::time_occluded(EmbreeCalls, std::span<const Ray>, std::span<std::uint8_t>, int) const {
  return start({}).error();
}
void EmbreeWitness::all_hits(std::span<const Ray>, std::span<std::vector<Hit>>, int) const {}
double EmbreeWitness::build_seconds() const { return 0; }
std::size_t EmbreeWitness::size_bytes() const { return 0; }
const std::string& EmbreeWitness::isa() const { return kNoIsa; }
const EmbreeOptions& EmbreeWitness::options() const { return kNoOptions; }

}  // namespace accel::validation

#endif

namespace accel::validation {
EmbreeWitness::EmbreeWitness(std::unique_ptr<Scene> scene) : scene_(std::move(scene)) {}
EmbreeWitness::EmbreeWitness(EmbreeWitness&&) noexcept = default;
EmbreeWitness& EmbreeWitness::operator=(EmbreeWitness&&) noexcept = default;
EmbreeWitness::~EmbreeWitness() = default;
}  // namespace accel::validation
