// The scene of kerf-sim: a mesh file, or the mesh inside a case or run folder.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "geometry/base/error.h"
#include "geometry/mesh/mesh.h"

namespace kerf {

/// Section plane that cuts an object open for display.
struct SectionPlane {
  enum class Through {
    kPoint,   ///< `point`
    kCenter,  ///< the middle of the object's box
    kCut,     ///< the middle of the box around the cut faces of a run
  };
  Through through = Through::kPoint;
  Vec3d point = Vec3d::Zero();    ///< mm
  Vec3d normal = Vec3d::UnitZ();  ///< unit; its side is removed
};

struct Scene {
  Mesh mesh;         ///< mm
  std::string note;  ///< for the user, about the picture; mostly empty
};

/// readMesh reads a file. exportBundle computes the post-operative mesh of a run folder or the solid of a case folder:
/// the display equals an export. A mesh file is scaled to mm: from `unit`, from its declared unit, or from its size,
/// with a note.
/// A case of several materials, a run of one, and a run with an added material have material colours, cut walls too. A
/// run of a case of one material has a separate colour for cut faces.
/// @param cut  cuts a case or a run open by a plane (tissue_mesh.h). An error for a mesh file, which has no inside, for
/// kCut on a case, and for a plane that removes the whole object. A plane that removes nothing makes a note.
/// @param unit  of a mesh file; empty: as declared.
/// @return an error that names the missing part, for a folder that is neither.
Expected<Scene> loadScene(const std::filesystem::path& path, const std::optional<SectionPlane>& cut = {},
                          const std::string& unit = {});

}  // namespace kerf
