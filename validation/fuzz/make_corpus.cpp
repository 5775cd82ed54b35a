// Writes the seeds of the binary formats, which the tree does not hold, into a folder for each target: make_corpus FOLDER.
//
// Small files are best: the shorter a seed, the more of its bytes matter. The seeds of text formats are in corpus/.
#include <zstd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "libaccel/core/counter_rng.h"
#include "libaccel/io/atomic_file.h"
#include "libaccel/io/npy.h"
#include "libaccel/io/structure_sections.h"
#include "libaccel/registry/any_accel.h"
#include "libaccel/registry/structures.h"
#include "validation/fuzz/fuzz_input.h"
#include "validation/stress/hostile_floats.h"

namespace {

using namespace accel;
namespace fs = std::filesystem;

void must(const Status& status) { fuzz::require(status.ok(), status ? "" : status.message()); }

template <class T>
void append(std::string& bytes, T value, std::endian order = std::endian::little) {
  std::array<char, sizeof(T)> raw;
  std::memcpy(raw.data(), &value, sizeof(T));
  if (order == std::endian::big) std::reverse(raw.begin(), raw.end());
  bytes.append(raw.data(), raw.size());
}

// A bent grid of n x n squares.
TriangleMesh grid_mesh(std::uint32_t n) {
  TriangleMesh mesh{Buffer<Vec3>((n + 1) * (n + 1)), Buffer<IndexTriple>(2 * n * n)};
  for (std::uint32_t i = 0; i < mesh.vertices.size(); ++i) {
    const auto x = static_cast<float>(i % (n + 1)), y = static_cast<float>(i / (n + 1));
    mesh.vertices[i] = {x, y, 0.25f * x * y};
  }
  for (std::uint32_t i = 0; i < n * n; ++i) {
    const std::uint32_t corner = i / n * (n + 1) + i % n;
    mesh.triangles[2 * i] = {corner, corner + 1, corner + n + 2};
    mesh.triangles[2 * i + 1] = {corner, corner + n + 2, corner + n + 1};
  }
  return mesh;
}

// Triangles, a quadrangle, and a property that is passed over.
std::string binary_ply(std::endian order) {
  std::string bytes = "ply\nformat binary_" + std::string(order == std::endian::big ? "big" : "little") +
                      "_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty double z\n"
                      "element face 3\nproperty list uchar int vertex_indices\nproperty uchar red\nend_header\n";
  for (int i = 0; i < 4; ++i) {
    append(bytes, static_cast<float>(i % 2), order);
    append(bytes, static_cast<float>(i / 2), order);
    append(bytes, 0.5 * i, order);
  }
  for (const std::vector<int>& face : {std::vector{0, 1, 2}, {1, 3, 2}, {0, 1, 3, 2}}) {
    append(bytes, static_cast<std::uint8_t>(face.size()), order);
    for (const int corner : face) append(bytes, corner, order);
    append(bytes, std::uint8_t{7}, order);
  }
  return bytes;
}

// A triangle in the binary container of glTF.
std::string glb() {
  const std::string json =
      R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],)"
      R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],)"
      R"("bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36}]})";
  std::string binary;
  for (const float x : {0, 0, 0, 1, 0, 0, 0, 1, 0}) append(binary, x);
  std::string bytes = "glTF";
  append(bytes, 2u), append(bytes, static_cast<std::uint32_t>(12 + 8 + json.size() + 8 + binary.size()));
  append(bytes, static_cast<std::uint32_t>(json.size())), bytes += "JSON" + json;
  append(bytes, static_cast<std::uint32_t>(binary.size())), bytes += std::string("BIN\0", 4) + binary;
  return bytes;
}

// With stored blocks: negative levels compress least.
std::string packed(const std::string& bytes, int level) {
  std::string result(ZSTD_compressBound(bytes.size()), '\0');
  const std::size_t size = ZSTD_compress(result.data(), result.size(), bytes.data(), bytes.size(), level);
  fuzz::require(ZSTD_isError(size) == 0, "zstd fails");
  result.resize(size);
  return result;
}

void write_npy_seeds(const fs::path& folder) {
  const std::vector<Ray> rays(2, Ray{.org = {1, 2, 3}, .dir = {0, 0, -1}});
  must(write_rays_npy(folder / "rays.npy", rays));
  must(write_hits_npy(folder / "hits.npy", std::vector<Hit>(3)));
  const std::string dict = "{'descr': '>f8', 'fortran_order': True, 'shape': (1, 6), }";
  std::string wide("\x93NUMPY\x02\x00", 8);
  append(wide, static_cast<std::uint32_t>(dict.size()));
  wide += dict;
  for (int i = 0; i < 6; ++i) append(wide, 1.0 + i, std::endian::big);
  must(write_file(folder / "wide.npy", wide));
}

// Every structure, with all arrays that any method reads.
void write_accel_seeds(const fs::path& folder) {
  for (const std::uint32_t n : {1u, 3u}) {
    const TriangleMesh mesh = grid_mesh(n);
    for (const MethodInfo& method : methods()) {
      const auto accel = AnyAccel::build(mesh, method.name, {.threads = 1, .max_leaf_size = 2});
      fuzz::require(accel.ok(), method.name + " cannot be built");
      std::string name = method.builder + "-" + method.traverser + "-" + std::to_string(n) + ".accel";
      visit_structure(accel->structure(), [&]<class Structure>(const Structure& structure) {
        const AccelMetadata metadata{Structure::kName, method.builder, "seed", {{"bins", "32"}}, {{"depth", 1}}, {}, {}};
        const auto scene = InstancedMeshes::make({mesh}, {Instance{}});
        must(method.instances ? save_accel(folder / name, metadata, *scene, structure)
                              : save_accel(folder / name, metadata, mesh, structure));
        return true;
      });
    }
  }
}

void append_grid(std::string& bytes, const TriangleMesh& mesh) {
  append(bytes, static_cast<std::uint8_t>(mesh.vertices.size() - 3));
  append(bytes, static_cast<std::uint8_t>(mesh.size() - 1));
  for (const Vec3& v : mesh.vertices) append(bytes, v.x), append(bytes, v.y), append(bytes, v.z);
  for (const IndexTriple& t : mesh.triangles)
    for (const std::uint32_t index : {t.v0, t.v1, t.v2}) append(bytes, static_cast<std::uint8_t>(index));
}

// A small grid with rays at its vertices, and random floats of all exponents; each wild and tame.
void write_methods_seeds(const fs::path& folder) {
  CounterRng rng(1, 0);
  for (int seed = 0; seed < 24; ++seed) {
    std::string bytes(1, static_cast<char>(seed & 1));
    TriangleMesh mesh = grid_mesh(2);
    if (seed >= 4)
      for (Vec3& vertex : mesh.vertices) vertex = validation::hostile_vec3(rng, 8);
    append_grid(bytes, mesh);
    for (std::uint8_t i = 0; i < 12; ++i) {
      append(bytes, i);
      const bool plain = seed < 8;
      const Vec3 org = plain ? Vec3{0.5f, 0.75f, 4} : validation::hostile_vec3(rng, 8);
      const Vec3 dir = plain ? Vec3{0.125f * i, 0, -1} : validation::hostile_vec3(rng, 8);
      for (const float x : {org.x, org.y, org.z, 0.0f, dir.x, dir.y, dir.z, 64.0f}) append(bytes, x);
    }
    must(write_file(folder / ("seed-" + std::to_string(seed)), bytes));
  }
}

}  // namespace

int main(int argc, char** argv) {
  fuzz::require(argc == 2, "usage: make_corpus FOLDER");
  const fs::path folder = argv[1];
  for (const char* target : {"obj", "scene", "ply", "ply_zst", "gltf", "npy", "accel", "methods"})
    fs::create_directories(folder / target);
  for (const std::endian order : {std::endian::little, std::endian::big}) {
    const std::string name = order == std::endian::big ? "big.ply" : "little.ply", ply = binary_ply(order);
    must(write_file(folder / "ply" / name, ply));
    must(write_file(folder / "ply_zst" / (name + ".stored.zst"), packed(ply, -100)));
    must(write_file(folder / "ply_zst" / (name + ".packed.zst"), packed(ply + ply, 19)));
  }
  must(write_file(folder / "gltf" / "triangle.glb", glb()));
  write_npy_seeds(folder / "npy");
  write_accel_seeds(folder / "accel");
  write_methods_seeds(folder / "methods");
  return 0;
}
