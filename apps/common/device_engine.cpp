#include "apps/common/device_engine.h"

#include "apps/common/text.h"
#include "libaccel/exec/cuda/device_accel.h"

namespace accel::apps {

namespace {

// Copies the rays, traces them and fetches the answers, which `fetch` does.
template <class Fetch>
Result<double> trace_on_device(const DeviceAccel& scene, std::string_view test, std::span<const Ray> rays, Query query,
                               const Fetch& fetch) {
  const auto batch = DeviceBatch::upload(rays);
  if (!batch) return batch.error();
  DeviceTraceOptions options;
  options.test = test;
  const auto timing = scene.trace(*batch, query, options);
  if (!timing) return timing.error();
  if (const Status fetched = fetch(*batch); !fetched) return fetched.error();
  return 1e-3 * static_cast<double>(timing->median_ms);
}

}  // namespace

Outcome<std::string> find_device() {
  const auto device = cuda_device_info();
  if (!device) return Failure(ExitStatus::unavailable, "--device cuda: " + device.message());
  return device->name + print(", compute capability %d.%d", device->compute_major, device->compute_minor);
}

Outcome<Engine> device_engine_of(const AnyAccel& accel, std::string_view test) {
  const auto scene = DeviceAccel::upload(accel.structure(), accel.method().name);
  if (!scene) return scene.error();
  Engine engine;
  engine.name = accel.method().name;
  engine.rays_per_call = Engine::kLongestCall * 16;  // devices want many rays at once, and take little time for them
  engine.closest = [scene = *scene, test](std::span<const Ray> rays, std::span<Hit> hits) {
    return trace_on_device(scene, test, rays, Query::closest, [&](const DeviceBatch& batch) { return batch.hits(hits); });
  };
  engine.occluded = [scene = *scene, test](std::span<const Ray> rays, std::span<std::uint8_t> occluded) {
    return trace_on_device(scene, test, rays, Query::any, [&](const DeviceBatch& batch) { return batch.occluded(occluded); });
  };
  return engine;
}

}  // namespace accel::apps
