// Everything that a program needs to load a scene, build a structure and trace rays.
//
//   const auto mesh = accel::load_mesh("scene.ply");
//   const auto scene = accel::AnyAccel::build(*mesh, "sbvh/stack");
//   const accel::Hit hit = scene->closest(ray);
//
// registry/any_accel.h says what a handle does, registry/accel_files.h how it is stored.
//
// Code that composes traversers and executors itself includes the headers of those layers, and is compiled with
// -ffp-contract=off (see geometry/watertight.h).
#pragma once

#include "libaccel/core/aabb.h"
#include "libaccel/core/buffer.h"
#include "libaccel/core/hit.h"
#include "libaccel/core/ray.h"
#include "libaccel/core/result.h"
#include "libaccel/core/vec3.h"
#include "libaccel/core/version.h"
#include "libaccel/geometry/mesh_facts.h"
#include "libaccel/geometry/triangle_mesh.h"
#include "libaccel/io/load_mesh.h"
#include "libaccel/io/load_scene.h"
#include "libaccel/io/npy.h"
#include "libaccel/io/structure_sections.h"
#include "libaccel/packet/ray_order.h"
#include "libaccel/rays/camera.h"
#include "libaccel/rays/offset_origin.h"
#include "libaccel/rays/ray_sets.h"
#include "libaccel/registry/accel_files.h"
#include "libaccel/registry/any_accel.h"
#include "libaccel/registry/multi_hit.h"
#include "libaccel/registry/refit.h"
