// Rays, trees and packets for the tests of packet/.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "libaccel/build/bvh2_octo.h"
#include "libaccel/build/sbvh.h"
#include "libaccel/core/counter_rng.h"
#include "libaccel/packet/frustum_trees.h"
#include "libaccel/rays/camera.h"
#include "libaccel/rays/ray_sets.h"
#include "libaccel/rays/surface_hits.h"
#include "libaccel/structure/bvh2.h"
#include "validation/stress/stress_rays.h"
#include "validation/stress/stress_scenes.h"

namespace accel::test {

inline Bvh2 octo_tree(const TriangleMesh& mesh) {
  auto built = Sbvh::build(mesh, {});
  EXPECT_TRUE(built) << built.message();
  EXPECT_TRUE(add_octo(built->structure));
  return std::move(built->structure);
}

// Rays of one origin each 90, at vertices and the middles of edges: from within the scene, from a vertex, which lies in the
// planes of its triangles, and from a zero of either sign.
inline std::vector<Ray> rays_of_pinholes(const TriangleMesh& mesh, const Aabb& bounds) {
  std::vector<Ray> rays;
  if (mesh.size() == 0) return rays;
  for (const Vec3 origin : {bounds.center(), mesh.triangle(0).v0, Vec3{-0.0f, 0, -0.0f}})
    for (std::size_t i = 0; i < 90; ++i) {
      const Triangle triangle = mesh.triangle(7 * i % mesh.size());
      const Vec3 target = i % 3 == 0 ? triangle.v0 : triangle.v0 + (triangle.v1 - triangle.v0) * 0.5f;
      rays.push_back({.org = origin, .dir = target - origin});
    }
  return rays;
}

// Rays to one point each 90, from vertices and the middles of edges, as shadow rays go to a light: within the scene, at a
// vertex, far outside; and some that go on beyond it.
inline std::vector<Ray> rays_to_lights(const TriangleMesh& mesh, const Aabb& bounds) {
  std::vector<Ray> rays;
  if (mesh.size() == 0) return rays;
  const Vec3 center = bounds.center(), outside = bounds.hi + bounds.extent() * 3.0f;
  for (const Vec3 light : {center, mesh.triangle(0).v0, outside, center})
    for (std::size_t i = 0; i < 90; ++i) {
      const Triangle triangle = mesh.triangle(7 * i % mesh.size());
      const Vec3 from = i % 3 == 0 ? triangle.v0 : triangle.v0 + (triangle.v2 - triangle.v0) * 0.5f;
      rays.push_back(ray_to(from, Vec3d(light)));
      if (rays.size() > 270 && i % 5 == 0) rays.back().t_max *= 1.5f;
    }
  return rays;
}

// Packets of rays of one face each: bundles from a small box through another one, pinholes, rays to lights, and rays that hurt,
// sorted by face.
inline std::vector<std::vector<Ray>> packets_for(const TriangleMesh& mesh, const Aabb& bounds, std::uint64_t seed) {
  std::vector<std::vector<Ray>> packets;
  CounterRng rng(seed, 0);
  const auto within = [&](const Aabb& box) {
    const Vec3 e = box.extent();
    return Vec3{box.lo.x + e.x * rng.next_float(), box.lo.y + e.y * rng.next_float(), box.lo.z + e.z * rng.next_float()};
  };
  const auto part_of = [&](float size) {
    const Vec3 lo = within(bounds), e = bounds.extent() * size;
    return Aabb{lo, lo + e};
  };
  std::vector<Ray> rays;
  for (const float size : {0.0f, 0.01f, 0.1f, 0.7f})
    for (int bundle = 0; bundle < 4; ++bundle) {
      const Aabb from = part_of(size), to = part_of(size);
      for (int i = 0; i < 90; ++i) {
        Ray ray{.org = within(from)};
        ray.dir = within(to) - ray.org;
        ray.t_min = bundle == 1 ? 0.1f : 0, ray.t_max = bundle == 2 ? 0.8f : std::numeric_limits<float>::infinity();
        rays.push_back(ray);
      }
    }
  const auto pinholes = rays_of_pinholes(mesh, bounds);
  rays.insert(rays.end(), pinholes.begin(), pinholes.end());
  const auto to_lights = rays_to_lights(mesh, bounds);
  rays.insert(rays.end(), to_lights.begin(), to_lights.end());
  const auto hostile = validation::stress_rays(mesh, 300, seed);
  rays.insert(rays.end(), hostile.begin(), hostile.end());
  for (std::size_t first = 0; first < rays.size(); first += 90) {
    std::vector<std::vector<Ray>> by_face(kNoFace);
    for (std::size_t i = first; i < std::min(first + 90, rays.size()); ++i)
      if (face_of(rays[i]) != kNoFace) by_face[face_of(rays[i])].push_back(rays[i]);
    for (auto& packet : by_face)
      if (!packet.empty()) packets.push_back(std::move(packet));
  }
  return packets;
}

// The rays of a picture in rows, bundles, rays that hurt and rays that are none, all mixed.
inline std::vector<Ray> mixed_rays(const TriangleMesh& mesh, const Aabb& bounds) {
  const auto camera = Camera::make(default_camera(bounds), 60, 40);
  EXPECT_TRUE(camera) << camera.message();
  const auto primary = primary_rays(*camera);
  std::vector<Ray> rays(primary->rays.begin(), primary->rays.end());
  for (const auto& packet : packets_for(mesh, bounds, 4)) rays.insert(rays.end(), packet.begin(), packet.end());
  const auto invalid = validation::invalid_rays();
  for (std::size_t i = 0; i < invalid.size(); ++i) rays.insert(rays.begin() + static_cast<std::ptrdiff_t>(37 * i), invalid[i]);
  return rays;
}

inline Frustum frustum_of(const std::vector<Ray>& packet, const Aabb& bounds) {
  return make_frustum(
      face_of(packet.front()), static_cast<std::uint32_t>(packet.size()), [&](std::uint32_t i) { return packet[i]; }, bounds);
}

inline std::vector<Frustum> frustums_for(const TriangleMesh& mesh, const Aabb& bounds, std::uint64_t seed) {
  std::vector<Frustum> frustums;
  for (const auto& packet : packets_for(mesh, bounds, seed)) frustums.push_back(frustum_of(packet, bounds));
  return frustums;
}

// Frustums by number, and what they meet: places of leaves, as in FrustumQueue.
using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

// Depth first by recursion, from front to back.
template <class Tree>
void walk(const Bvh2View& tree, const Frustum& frustum, std::uint32_t number, NodeRef ref, Pairs& pairs) {
  const auto& node = Tree::nodes(tree)[ref];
  for (std::uint32_t rank = 0; rank < Tree::kArity; ++rank) {
    const std::uint32_t c = rank ^ Tree::order(node, frustum.signs);
    const NodeRef child = node.child[c];
    if (child == kNoNode || !frustum.meets(node.bounds(static_cast<int>(c)))) continue;
    if (is_leaf(child))
      pairs.push_back({number, kLeafBit | (ref * Tree::kArity + c)});
    else
      walk<Tree>(tree, frustum, number, child, pairs);
  }
}
template <class Tree>
Pairs walk(const Bvh2& tree, const std::vector<Frustum>& frustums) {
  Pairs pairs;
  for (std::uint32_t f = 0; f < frustums.size(); ++f) walk<Tree>(tree.view(), frustums[f], f, Tree::root(tree.view()), pairs);
  return pairs;
}

// The same with the leaves themselves instead of their places.
template <class Tree>
Pairs leaves_of(const Bvh2& tree, Pairs pairs) {
  for (auto& [frustum, place] : pairs)
    place = Tree::nodes(tree.view())[leaf_quad(place) / Tree::kArity].child[leaf_quad(place) % Tree::kArity];
  return pairs;
}

}  // namespace accel::test
