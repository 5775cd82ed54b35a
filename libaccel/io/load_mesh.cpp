#include "libaccel/io/load_mesh.h"

#include <algorithm>
#include <cctype>
#include <new>
#include <string>

#include "libaccel/core/out_of_memory.h"
#include "libaccel/io/gltf.h"
#include "libaccel/io/input_bytes.h"
#include "libaccel/io/obj.h"
#include "libaccel/io/ply.h"

namespace accel {
namespace {

using Parser = Result<SceneData> (*)(std::span<const std::byte>, const std::string&, const LoadOptions&);

// Of a format that has a mesh and nothing else.
template <Result<TriangleMesh> (*kParse)(std::span<const std::byte>, const std::string&, const LoadOptions&)>
Result<SceneData> parse_mesh(std::span<const std::byte> bytes, const std::string& name, const LoadOptions& options) {
  Result<TriangleMesh> mesh = kParse(bytes, name, options);
  if (!mesh) return mesh.error();
  return SceneData{*std::move(mesh), {}, {}, {}};
}

// By the name's ending, in front of .zst where it has that; null for other names.
Parser parser_for(const std::filesystem::path& path) {
  const std::filesystem::path inner = is_zstd_name(path) ? path.stem() : path;
  std::string extension = inner.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (extension == ".obj") return parse_mesh<parse_obj>;
  if (extension == ".ply") return parse_mesh<parse_ply>;
  return extension == ".gltf" || extension == ".glb" ? parse_gltf : nullptr;
}

}  // namespace

bool is_mesh_file_name(const std::filesystem::path& path) { return parser_for(path) != nullptr; }

Result<SceneData> load_file(const std::filesystem::path& path, const LoadOptions& options) try {
  const std::string name = path.string();
  const Parser parse = parser_for(path);
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) return Error{"'" + name + "' is a folder; name a scene file in it"};
  if (parse == nullptr)
    return Error{"'" + name + "' is not named like a scene: .obj, .ply, .gltf and .glb can be read, each with or without .zst"};
  try {
    const Result<InputBytes> input = read_input(path, options.progress);
    return input ? parse(input->bytes, name, options) : input.error();
  } catch (const std::bad_alloc&) {
    return Error{name + ": not enough memory to load it"};
  }
} catch (const std::bad_alloc&) {
  return out_of_memory("loading a scene");
}

Result<TriangleMesh> load_mesh(const std::filesystem::path& path, const LoadOptions& options) try {
  const Result<SceneData> file = load_file(path, options);
  return file ? file->one_mesh() : file.error();
} catch (const std::bad_alloc&) {
  return out_of_memory("loading a mesh");
}

}  // namespace accel
