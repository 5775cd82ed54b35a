// What stands beside a scene file and says how to look at it, cameras and a light, and which instances it consists of.
//
// For a scene NAME.ply.zst, the first of these that exists is read:
//
//   1. NAME.ply.zst.json       the scene's name with .json behind it
//   2. NAME.json               the scene's name with .json in place of its ending (.ply, .ply.zst, .obj, .gltf, ...)
//   3. the rows of scenes.tsv in the same folder whose column `file` is the scene's name
//
// The JSON form, in which every key is optional and unknown keys are errors:
//
//   { "cameras": [ { "name": "door", "eye": [x, y, z], "at": [x, y, z], "up": [x, y, z], "vfov": degrees } ],
//     "light": { "center": [x, y, z], "half_u": [x, y, z], "half_v": [x, y, z] },
//     "instances": [ { "mesh": "tree.ply", "transform": [ 12 numbers ] } ] }
//
// A light may be given as "corner", "edge_u" and "edge_v" instead, or as "point": [x, y, z] alone, whose half edges are zero. A
// camera needs "eye" and "at"; up defaults to +y, vfov to 45, the name to "camera N", counted from 1.
//
// With "instances" the scene is these and nothing else. The mesh of one is a file in any format of load_mesh(), relative to the
// folder of the description, and without one the file that the description is for; what stands beside that file is not read.
// Its place is a transform, three rows of four numbers one after the other (the last of each is the translation), or "scale" (a
// number, or three along the axes; negative ones mirror), "rotate" ([x, y, z, degrees]: about this axis, counter-clockwise seen
// from its tip) and "translate" ([x, y, z]), any of them, applied in this order.
//
// The table form is lines of columns between tabs; the header line, which begins with #, names them. Needed are name, file,
// eye, at, up and vfov_deg (three numbers between blanks for a vector). Rows named NAME and NAME#2 are two cameras of one
// scene.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "libaccel/core/affine.h"
#include "libaccel/core/camera_description.h"
#include "libaccel/core/light_description.h"
#include "libaccel/core/result.h"

namespace accel {

// An instance as a description has it: files are not looked at.
struct InstanceDescription {
  std::filesystem::path mesh;  // empty: the scene's own; relative to the description's folder
  Affine transform;
};

struct SceneDescription {
  std::vector<CameraDescription> cameras;
  std::optional<LightDescription> light;
  std::optional<std::vector<InstanceDescription>> instances;
  std::filesystem::path source;  // the file that said so; empty where none stands beside the scene
};

// The description of a scene file, empty where there is none.
Result<SceneDescription> find_scene_description(const std::filesystem::path& scene);

// The names that a description in JSON may have, in this order.
std::vector<std::filesystem::path> scene_description_names(const std::filesystem::path& scene);

// The two forms, as text; `name` is the file's name for messages.
Result<SceneDescription> parse_scene_json(std::string_view text, const std::string& name);
Result<SceneDescription> parse_scene_table(std::string_view text, const std::string& name, std::string_view scene_file);

// Whether a camera can be used: finite, eye and at distinct, up not along the view direction, vfov strictly between 0 and 180.
// The message of the error says what is wrong.
Status validate(const CameraDescription& camera);

}  // namespace accel
