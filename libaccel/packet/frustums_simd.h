// face_of() and make_frustum() (packet/frustum.h) with rays in SIMD lanes: the same faces and frustums, bit for bit. Compiled
// for every target of the machine's family, by Highway; the best that the machine has runs.
#pragma once

#include "libaccel/packet/localized.h"

namespace accel {

// faces[i] of rays[i].
void find_faces_simd(const Ray* rays, std::size_t count, std::uint8_t* faces);

// frustums[i] of active packet i; faces[k] is the face of ray ids[k]. Of the batch, only rays and packets are read.
void make_frustums_simd(const LocalizedBatch& batch, const std::uint8_t* faces, const Aabb& bounds, Frustum* frustums);

}  // namespace accel
