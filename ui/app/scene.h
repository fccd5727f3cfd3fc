// What kerf-sim shows: a mesh file, or the mesh inside a case or run folder.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "geometry/base/error.h"
#include "geometry/mesh/mesh.h"

namespace kerf {

/// Where an object is cut open to be looked at.
struct SectionPlane {
  enum class Through {
    kPoint,   ///< `point`
    kCenter,  ///< the middle of the object's box
    kCut,     ///< the middle of the box around the cut faces of a run
  };
  Through through = Through::kPoint;
  Vec3d point = Vec3d::Zero();    ///< mm
  Vec3d normal = Vec3d::UnitZ();  ///< unit; what lies on its side is taken away
};

struct Scene {
  Mesh mesh;         ///< mm
  std::string note;  ///< for the user, about the picture; most often empty
};

/// A file is read by readMesh. A run folder shows its post-operative mesh, a case folder its solid, both computed by
/// exportBundle: what is shown is what would be exported. A mesh file is scaled to mm: from `unit`, or from what it
/// declares, or from what its size says, with a note.
/// A case of several materials, and a run of one, is coloured by them, cut walls too, and so is a run in which another
/// one was added; a run of a case of one material has its cut faces in their own colour.
/// @param cut  shows a case or a run cut open by a plane (tissue_mesh.h). An error for a mesh file, which has no
/// inside, for kCut on a case, and for a plane that takes all of the object away; one that takes nothing away makes a
/// note.   @param unit  of a mesh file; empty: as it says.
/// @return an error naming what is missing, for a folder that is neither.
Expected<Scene> loadScene(const std::filesystem::path& path, const std::optional<SectionPlane>& cut = {},
                          const std::string& unit = {});

}  // namespace kerf
