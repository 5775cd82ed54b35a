#include "libaccel/io/gltf_meshes.h"

#include <algorithm>
#include <numeric>
#include <optional>
#include <span>
#include <string>

namespace accel {
namespace {

constexpr std::uint32_t kNoVertex = 0xffffffffu;

// Triangles of a primitive, by the numbers that OpenGL gives to its modes; other modes have none.
constexpr std::uint64_t kTriangles = 4, kStrip = 5, kFan = 6;

void add_triangles(std::uint64_t mode, std::span<const std::uint32_t> corners, std::vector<IndexTriple>& triangles) {
  if (corners.size() < 3) return;
  if (mode == kTriangles)
    for (std::size_t i = 0; i + 2 < corners.size(); i += 3) triangles.push_back({corners[i], corners[i + 1], corners[i + 2]});
  else if (mode == kStrip)  // every other triangle is turned, so that all have the same side in front
    for (std::size_t i = 0; i + 2 < corners.size(); ++i)
      triangles.push_back({corners[i], corners[i + 1 + i % 2], corners[i + 2 - i % 2]});
  else
    for (std::size_t i = 1; i + 1 < corners.size(); ++i) triangles.push_back({corners[i], corners[i + 1], corners[0]});
}

}  // namespace

JsonCursor gltf_entry(const JsonCursor& document, const char* list, const JsonCursor& index) {
  const JsonCursor entries = document[list];
  return entries[index.natural_below(entries.size())];
}

std::optional<JsonCursor> gltf_extension(const JsonCursor& holder, const char* name) {
  const auto extensions = holder.find("extensions");
  return extensions ? extensions->find(name) : std::nullopt;
}

void GltfMeshes::tick() {
  const auto all = document_.find("meshes");
  const double count = static_cast<double>(all ? std::max<std::size_t>(all->size(), 1) : 1);
  if (!ticker_.tick(static_cast<double>(meshes_.size()) / count)) throw FormatError{std::string(kInterrupted)};
}

std::uint32_t GltfMeshes::number_of(const JsonCursor& index) {
  const auto [known, is_new] = numbers_.try_emplace(index.natural(), static_cast<std::uint32_t>(meshes_.size()));
  if (is_new) meshes_.push_back(read(gltf_entry(document_, "meshes", index)));
  return known->second;
}

TriangleMesh GltfMeshes::read(const JsonCursor& mesh) {
  std::vector<Vec3> vertices;
  std::vector<IndexTriple> triangles;
  std::vector<Positions*> used;
  const JsonCursor primitives = mesh["primitives"];
  for (std::size_t p = 0; p < primitives.size(); ++p) {
    tick();
    const JsonCursor primitive = primitives[p];
    const auto given = primitive.find("mode"), position = primitive["attributes"].find("POSITION");
    const std::uint64_t mode = given ? given->natural() : kTriangles;
    if (mode < kTriangles || mode > kFan || !position) continue;
    Positions& positions = positions_of(primitive, *position);
    used.push_back(&positions);
    std::vector<std::uint32_t> corners = corners_of(primitive, mode, positions.vertex_of_point.size());
    buffers_.charge(mode == kTriangles ? corners.size() / 3 : corners.size(), primitive);
    for (std::uint32_t& corner : corners) corner = positions.vertex(corner, vertices);
    add_triangles(mode, corners, triangles);
    if (triangles.size() > kMaxTriangles) mesh.fail("has more triangles than can be traced");
  }
  for (Positions* positions : used) positions->forget_vertices();
  return {Buffer<Vec3>::copy_of(vertices), Buffer<IndexTriple>::copy_of(triangles)};
}

// The number of a point's vertex in the mesh that is being read.
std::uint32_t GltfMeshes::Positions::vertex(std::uint32_t point, std::vector<Vec3>& vertices) {
  std::uint32_t& vertex = vertex_of_point[point];
  if (vertex == kNoVertex) {
    vertex = static_cast<std::uint32_t>(vertices.size()), known.push_back(point);
    vertices.push_back({points[3 * point], points[3 * point + 1], points[3 * point + 2]});
  }
  return vertex;
}

void GltfMeshes::Positions::forget_vertices() {
  for (const std::uint32_t point : known) vertex_of_point[point] = kNoVertex;
  known.clear();
}

GltfMeshes::Positions& GltfMeshes::positions_of(const JsonCursor& primitive, const JsonCursor& index) {
  const auto [known, is_new] = positions_.try_emplace(index.natural());
  Positions& positions = known->second;
  if (!is_new) return positions;
  const JsonCursor accessor = gltf_entry(document_, "accessors", index);
  if (gltf_extension(primitive, "KHR_draco_mesh_compression") && !accessor.find("bufferView"))
    primitive.fail("is compressed by KHR_draco_mesh_compression, which is not supported; export the scene without it");
  positions.points = buffers_.floats(accessor, 3);
  positions.vertex_of_point.assign(positions.points.size() / 3, kNoVertex);
  return positions;
}

// The vertices that a primitive names, or all of them in their order.
std::vector<std::uint32_t> GltfMeshes::corners_of(const JsonCursor& primitive, std::uint64_t mode, std::uint64_t points) {
  const auto index = primitive.find("indices");
  std::vector<std::uint32_t> corners(index ? 0 : points);
  if (index)
    corners = buffers_.indices(gltf_entry(document_, "accessors", *index));
  else
    std::iota(corners.begin(), corners.end(), 0u);
  if (mode == kTriangles && corners.size() % 3 != 0)
    primitive.fail("has " + std::to_string(corners.size()) + " corners, which is no multiple of three");
  const auto largest = std::max_element(corners.begin(), corners.end());
  if (largest != corners.end() && *largest >= points)
    primitive.fail("names vertex " + std::to_string(*largest) + " of " + std::to_string(points) + ", counted from 0");
  return corners;
}

}  // namespace accel
