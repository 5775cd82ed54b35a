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
#include <cstring>

#include "libaccel/exec/cpu.h"
#include "libaccel/trace/multi_hit.h"

namespace accel::validation {

struct EmbreeWitness::Scene {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  std::vector<RTCScene> meshes;            // of instances
  std::vector<std::uint32_t> first_prims;  // likewise: by instance
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
    case EmbreeQuality::low: return RTC_BUILD_QUALITY_LOW;
    case EmbreeQuality::medium: return RTC_BUILD_QUALITY_MEDIUM;
    case EmbreeQuality::high: return RTC_BUILD_QUALITY_HIGH;
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
  void* vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Vec3), mesh.vertices.size());
  void* triangles = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(IndexTriple), mesh.size());
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

Hit intersect(RTCScene scene, std::span<const std::uint32_t> first_prims, const Ray& ray) {
  if (!is_traceable(ray)) return {};
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

bool is_occluded(RTCScene scene, const Ray& ray) {
  if (!is_traceable(ray)) return false;
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
  keep.hits->push_back({RTCRayN_tfar(arguments->ray, n, 0), RTCHitN_u(hit, n, 0), RTCHitN_v(hit, n, 0),
                        first_prim + RTCHitN_primID(hit, n, 0)});
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

std::vector<Hit> all_hits_of(RTCScene scene, std::span<const std::uint32_t> first_prims, const Ray& ray) {
  std::vector<Hit> hits;
  if (!is_traceable(ray)) return hits;
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

}  // namespace

bool EmbreeWitness::available() { return true; }

std::string EmbreeWitness::version() {
  return "Embree " + std::to_string(RTC_VERSION_MAJOR) + "." + std::to_string(RTC_VERSION_MINOR) + "." + std::to_string(RTC_VERSION_PATCH);
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
  }
  return finish(*std::move(owned));
}

void EmbreeWitness::closest(std::span<const Ray> rays, std::span<Hit> hits, int threads) const {
  for_each_block(rays.size(), threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) hits[i] = intersect(scene_->scene, scene_->first_prims, rays[i]);
  });
}

void EmbreeWitness::occluded(std::span<const Ray> rays, std::span<std::uint8_t> occluded, int threads) const {
  for_each_block(rays.size(), threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) occluded[i] = is_occluded(scene_->scene, rays[i]) ? 1 : 0;
  });
}

void EmbreeWitness::all_hits(std::span<const Ray> rays, std::span<std::vector<Hit>> hits, int threads) const {
  ACCEL_ASSERT(scene_->options.all_hits);
  for_each_block(rays.size(), threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) hits[i] = all_hits_of(scene_->scene, scene_->first_prims, rays[i]);
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
void EmbreeWitness::closest(std::span<const Ray>, std::span<Hit>, int) const {}
void EmbreeWitness::occluded(std::span<const Ray>, std::span<std::uint8_t>, int) const {}
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
