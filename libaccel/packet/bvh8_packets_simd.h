// Packets of rays that run nearly the same way through a Bvh8, a ray in each SIMD lane: Wald et al. 2001, "Interactive
// Rendering with Coherent Ray Tracing"; Reshetov et al. 2005, "Multi-Level Ray Tracing Algorithm" (frustums that skip what no
// ray meets); Overbeck et al. 2008, "Large Ray Packets for Real-time Whitted Ray Tracing" (rays that take part, by groups).
//
// A node's eight boxes are tested against the packet's frustum (packet/frustum.h) at once. Where it meets a box, the packet's
// rays are tested against that, as many as a vector has lanes at a time, when its turn comes, so that nearer hits have
// shortened them; groups without a ray that enters leave the packet there. Leaves are tested triangle by triangle, by the
// groups that are left.
//
// What the rays of a packet have in common is not computed for each. Where they start at one point, as those of a camera,
// planes of boxes and vertices are moved there once for all of them, and so is the distance of a triangle's plane; and boxes
// are seen from there by groups (packet/pencil_simd-inl.h), so that only groups that may meet a box ask it. Where rays run the
// same way along an axis, none chooses which planes are near.
//
// Some packets are on their way at a time, by turns, as single rays are (trace/bvh8_simd.h): after a node, whose children are
// not here yet, the next packet goes on.
//
// Any-hit queries begin with the leaf that has stopped most rays of the packet before, if that was a quarter of them. Its box
// is not asked: the part of a wall that a spatial split has left in that leaf names the whole wall.
//
// The box test of a ray is that of trace/bvh8_ray.h, so that a ray meets the triangles that it meets by itself, in another
// order, and has the same hit bit for bit. But for those that core/hit.h excepts: the remembered leaf, whose box is not asked,
// may have one that no box lets pass, and another order one that would have been culled.
//
// Instances. Packets go through the tree over them in the same way. The rays that come to one make packets in its space, one
// for each face that they have there, and what they hit is brought back; few rays go by turns.
#pragma once

#include <cstdint>

#include "libaccel/packet/localized.h"
#include "libaccel/structure/bvh8.h"
#include "libaccel/structure/two_level_bvh8.h"

namespace accel {

// answers[i] answers rays[i] for all rays of active packets; nothing else is written. faces[k] is the face of ray ids[k], the
// same for all rays of a packet. The root is a node, and no tree is deeper than kMostBvh8Depth. Of the batch, only rays and
// packets are read. May throw std::bad_alloc.
void trace_bvh8_packets_simd(const Bvh8View& view, const LocalizedBatch& batch, const std::uint8_t* faces, Hit* hits);
void trace_bvh8_packets_simd(const TwoLevelBvh8View& view, const LocalizedBatch& batch, const std::uint8_t* faces, Hit* hits);
//
// Any-hit queries may begin at the far end: what is around a light is in the way of many rays, or of none.
void trace_bvh8_packets_simd(const Bvh8View& view, const LocalizedBatch& batch, const std::uint8_t* faces,
                             std::uint8_t* occluded, bool from_far_end = false);
void trace_bvh8_packets_simd(const TwoLevelBvh8View& view, const LocalizedBatch& batch, const std::uint8_t* faces,
                             std::uint8_t* occluded, bool from_far_end = false);

}  // namespace accel
