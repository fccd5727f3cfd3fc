// Writing mesh files.
#pragma once

#include <filesystem>
#include <string>

#include "geometry/error.h"
#include "geometry/mesh.h"

namespace kerf {

struct MeshWriteOptions {
  /// PLY: positions as double instead of float32. Other formats hold float32 whatever is asked.
  bool double_positions = false;
  bool colors = true;  ///< write vertex and face colours where the format has them (PLY both, OBJ and OFF vertices, OFF faces)
  /// One line for the header or a comment (80 characters in STL). Must not name files or people: it travels with the mesh.
  std::string comment = "Kerf";
};

/// Writes `mesh` in the format of the extension (.stl .ply .obj .off), beside the target first, then renamed: an
/// existing file is replaced only by a complete one.
/// Positions are rounded to float32 (PLY with double_positions: kept) and come back bit for bit; vertices keep their
/// order and count, triangles theirs. STL carries facet normals, no colour, and a header that never begins with "solid".
/// STL and OFF go through OpenMesh, which refuses anything but a 2-manifold: then the Error names the first triangle it
/// could not add. PLY and OBJ hold any mesh.
/// @pre   indices in range, finite positions.
/// @throws nothing; full disk, missing folder or permission end in an Error with the system's reason.
Expected<void> writeMesh(const std::filesystem::path& path, const Mesh& mesh, const MeshWriteOptions& options = {});

}  // namespace kerf
