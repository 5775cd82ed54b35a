// device_accel.h where the library is built without CUDA: the same functions, and the reason why they cannot serve.
#include "libaccel/exec/cuda/device_accel.h"

namespace accel {

namespace {
Error no_cuda() { return Error{"this build has no CUDA: configure with -DACCEL_WITH_CUDA=ON on a machine that has nvcc"}; }
}  // namespace

// No object of these types is ever made.
struct DeviceBatch::State {};
struct DeviceAccel::State {};

Result<DeviceInfo> cuda_device_info() { return no_cuda(); }

Result<DeviceBatch> DeviceBatch::upload(std::span<const Ray>) { return no_cuda(); }
std::size_t DeviceBatch::size() const { return 0; }
Status DeviceBatch::hits(std::span<Hit>) const { return no_cuda(); }
Status DeviceBatch::occluded(std::span<std::uint8_t>) const { return no_cuda(); }

Result<DeviceAccel> DeviceAccel::upload(const AnyStructure&, std::string_view) { return no_cuda(); }
Result<DeviceTiming> DeviceAccel::trace(const DeviceBatch&, Query, const DeviceTraceOptions&) const { return no_cuda(); }
std::size_t DeviceAccel::size_bytes() const { return 0; }

}  // namespace accel
