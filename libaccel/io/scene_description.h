// What stands beside a scene file and says how to look at it: cameras and a light.
//
// For a scene NAME.ply.zst, the first of these that exists is read:
//
//   1. NAME.ply.zst.json       the scene's name with .json behind it
//   2. NAME.json               the scene's name with .json in place of its ending (.ply, .obj, each with or without .zst)
//   3. the rows of scenes.tsv in the same folder whose column `file` is the scene's name
//
// The JSON form, in which every key is optional and unknown keys are errors:
//
//   { "cameras": [ { "name": "door", "eye": [x, y, z], "at": [x, y, z], "up": [x, y, z], "vfov": degrees } ],
//     "light": { "center": [x, y, z], "half_u": [x, y, z], "half_v": [x, y, z] } }
//
// A light may be given as "corner", "edge_u" and "edge_v" instead, or as "point": [x, y, z] alone, whose half edges are zero. A
// camera needs "eye" and "at"; up defaults to +y, vfov to 45, the name to "camera N", counted from 1.
//
// The table form is lines of columns between tabs; the header line, which begins with #, names them. Needed are name, file,
// eye, at, up and vfov_deg (three numbers between blanks for a vector). Rows named NAME and NAME#2 are two cameras of one
// scene.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "libaccel/core/camera_description.h"
#include "libaccel/core/light_description.h"
#include "libaccel/core/result.h"

namespace accel {

struct SceneDescription {
  std::vector<CameraDescription> cameras;
  std::optional<LightDescription> light;
  std::filesystem::path source;  // the file that said so; empty where none stands beside the scene
};

// The description of a scene file, empty where there is none.
Result<SceneDescription> find_scene_description(const std::filesystem::path& scene);

// The two forms, as text; `name` is the file's name for messages.
Result<SceneDescription> parse_scene_json(std::string_view text, const std::string& name);
Result<SceneDescription> parse_scene_table(std::string_view text, const std::string& name, std::string_view scene_file);

// Whether a camera can be used: finite, eye and at distinct, up not along the view direction, vfov strictly between 0 and 180.
// The message of the error says what is wrong.
Status validate(const CameraDescription& camera);

}  // namespace accel
