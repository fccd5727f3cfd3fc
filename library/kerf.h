// Kerf as a library: read a surface, make it a solid, cut it, get the mesh for the printer.
//
//   const auto scan = kerf::readMesh("arch.stl");
//   const auto model = kerf::Workpiece::bake(scan->mesh, {.unit = scan->declared_unit});
//   const auto cut = model->cut(kerf::ToolChoice::named("round-014"), kerf::PathChoice::file("cavity.toml"));
//   kerf::writeMesh("cut.stl", cut->mesh);
//
// Everything in mm, right-handed, in the frame of the scan. A function that may fail returns Expected<T>: a value or an
// Error with file, place, found, expected and a hint. Nothing throws. Functions may run on several threads at once on
// different objects; a long one takes a Progress that reports and cancels, and uses all cores.
//
// This header is the interface, with the headers that it includes; other headers of Kerf are its own.
#pragma once

#include "geometry/base/assets.h"
#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/case/case_bundle.h"
#include "geometry/formats/mesh_io.h"
#include "geometry/formats/mesh_writer.h"
#include "geometry/mesh/mesh.h"
#include "geometry/mesh/mesh_check.h"
#include "geometry/tool/tool_file.h"
#include "library/workpiece.h"
#include "preprocess/bake/bake.h"
#include "preprocess/volume/label_volume.h"
#include "sim/hand/path.h"
#include "sim/run/cut/cut_remarks.h"
#include "sim/run/export/export_bundle.h"
#include "sim/run/export/placed_pieces.h"
#include "sim/run/report/run_series.h"
#include "sim/run/scene/load_scene.h"
#include "sim/session/session.h"

#ifdef KERF_INSTALLED_PREFIX  // by find_package(kerf): tools, materials and the reader of volumes are there
namespace kerf::internal {
inline const bool kPrefixIsSet = (setInstalledPrefix(KERF_INSTALLED_PREFIX), true);
}  // namespace kerf::internal
#endif
