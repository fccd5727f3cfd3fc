// Writing mesh files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/formats/named_part.h"
#include "geometry/mesh/mesh.h"

namespace kerf {

struct MeshWriteOptions {
  /// PLY: positions as double instead of float32. Other formats hold float32 whatever is asked.
  bool double_positions = false;
  /// Write vertex and face colours where the format has them: PLY and OFF both, OBJ those of the vertices, 3MF those of
  /// the faces, or of the vertices if there are no others.
  bool colors = true;
  /// Comment line of PLY and OBJ, the Application of 3MF; the others hold none. It travels with the mesh, so it must
  /// name neither files nor people; line ends in it become blanks.
  std::string comment = "Kerf";
  /// Objects of 3MF and OBJ, with their names; empty: one without. The others hold none. In 3MF each part has vertices
  /// of its own: their order is that of the mesh only if each part has used vertices behind those of the one before.
  /// @pre ascending, the first at triangle 0, all below the number of triangles.
  std::vector<NamedPart> objects{};
};

/// Writes `mesh` in the format of the extension (writableExtensions()), beside the target first, then renamed: an
/// existing file is replaced only by a complete one.
/// Positions are rounded to float32 (PLY with double_positions: kept) and come back bit for bit; vertices keep their
/// order and count, triangles theirs. STL carries facet normals, no colour, and a header that never begins with
/// "solid". STL and OFF go through OpenMesh, which refuses what is not a 2-manifold (open is fine): the Error then
/// names the first triangle it could not add. A second opinion besides checkMesh. PLY and OBJ hold any mesh. 3MF
/// says millimetres and one object, or one per named part, which calls itself a "surface" if it is not closed; a
/// triangle that repeats a vertex is refused. A path that is no regular file (/dev/stdout) is written to directly.
/// @pre   indices in range, finite positions.
/// @throws nothing; full disk, missing folder or permission end in an Error with the system's reason.
Expected<void> writeMesh(const std::filesystem::path& path, const Mesh& mesh, const MeshWriteOptions& options = {});

/// Whether writeMesh() has a chance: a known extension, a folder that takes new files. Leaves nothing behind.
Expected<void> canWriteMesh(const std::filesystem::path& path);

}  // namespace kerf
