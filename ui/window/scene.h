// What kerf-sim shows: a mesh file, or the mesh inside a case or run folder.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "geometry/error.h"
#include "geometry/mesh.h"

namespace kerf {

struct Scene {
  Mesh mesh;                        ///< mm
  std::filesystem::path mesh_file;  ///< the file it was read from
  std::string unit;                 ///< for the eye: "mm", "mm (the file names none)", "inch, shown in mm"
};

/// A file is read by readMesh. A run folder shows its post-operative mesh with the cut faces in their own colour, a
/// case folder its solid, both computed by exportBundle: what is shown is what would be exported. A mesh file whose
/// header declares another unit is scaled to mm, one that declares none is taken as mm.
/// A case of several materials is coloured by them.
/// @param cut  shows a case cut open by this plane, what lies above it taken away (tissue_view.h); an error for the
/// rest.
/// @return an error naming what is missing, for a folder that is neither.
Expected<Scene> loadScene(const std::filesystem::path& path, const std::optional<Plane>& cut = {});

}  // namespace kerf
