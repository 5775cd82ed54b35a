// glTF 2.0 (Khronos Group; ISO/IEC 12113): the triangles, perspective cameras and first point or spot light of a scene.
//
// Both containers, .gltf (JSON) and .glb, are told apart by their first bytes. Read is the scene that the file names, its first
// one where it names none, or all nodes where it has no scenes. Nodes are visited depth first in the order of the file, and the
// triangles of a node's mesh are those of its primitives, one after the other: lists, strips and fans, with or without indices.
// Points, lines and what a scale of zero hides are passed over, and so are materials, textures, morph targets, animations, and
// skins, whose meshes stay where their nodes are: the scene is as modelled. The transforms of nodes are multiplied in double
// and rounded to floats, and so is each position that they place.
//
// Meshes that many nodes place (or EXT_mesh_gpu_instancing) are kept as instances where one mesh would be large and mostly
// copies (geometry/instanced_meshes.h). prim_ids are the same either way. Instances need transforms that have an inverse
// (geometry/instanced_meshes.h).
//
// Of the extensions that a file requires, those of materials, textures and the like are passed over; known are
// KHR_mesh_quantization, EXT_mesh_gpu_instancing and KHR_lights_punctual; others, compressed meshes among them, are errors.
//
// A file of few bytes may name the same numbers any number of times. It may make no more than kMostPerByte triangles and
// instances for each byte that it has.
//
// Errors name the file and the way to the value, as in "scene.gltf: accessors[3].count: must be a number".
#pragma once

#include <span>
#include <string>

#include "libaccel/geometry/scene_data.h"
#include "libaccel/io/load_mesh.h"

namespace accel {

// `name` is the file's: for messages, and to find the files that it names.
Result<SceneData> parse_gltf(std::span<const std::byte> bytes, const std::string& name, const LoadOptions& options = {});

}  // namespace accel
