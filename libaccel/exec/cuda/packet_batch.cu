// The stages of packets (packet/packet_batch.h) on a device, but for the intersection, which each method compiles for its
// triangle tests.
#include "libaccel/exec/cuda/cuda_primitives.cuh"
#include "libaccel/packet/packet_batch.h"

namespace accel {

template class PacketBatch<cuda::CudaPrimitives>;

}  // namespace accel
