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
  /// PLY: positions as double instead of float32. Other formats always hold float32.
  bool double_positions = false;
  /// Write vertex and face colours if the format has them: PLY and OFF both, OBJ those of the vertices, 3MF those of
  /// the faces, else of the vertices.
  bool colors = true;
  /// PLY: a number per vertex, as the property `quality` (float), which MeshLab and CloudCompare show as a scalar; NaN:
  /// none. Empty: no such property. The other formats have none.
  std::vector<float> vertex_quality{};
  /// Comment line of PLY and OBJ, the Application of 3MF; the other formats have none. It travels with the mesh, so it
  /// must name neither files nor people. Line ends in it become blanks.
  std::string comment = "Kerf";
  /// Objects of 3MF and OBJ, with their names; empty: one without a name. The other formats have none. In 3MF each part
  /// has separate vertices: they keep the order of the mesh only if each part uses vertices behind those of the
  /// previous part.
  /// @pre ascending, the first at triangle 0, all below the number of triangles.
  std::vector<NamedPart> objects{};
};

/// Writes `mesh` in the format of the extension (writableExtensions()), beside the target first, then renamed: only a
/// complete file replaces an existing one.
/// Before that it reads the bytes back: every corner of every triangle must be there, bit for bit. Hence the file has
/// every property of the checked mesh: closed, volume, extent, pieces, no crossings.
/// Rounds positions to float32 (not PLY with double_positions); they read back bit for bit. Vertices and triangles keep
/// their order and count. STL carries facet normals, no colour, and a header that never begins with "solid". STL and
/// OFF go through OpenMesh, which rejects a non-2-manifold (open is valid): the Error then names the first triangle it
/// could not add. A second check beside checkMesh(). PLY and OBJ hold any mesh. 3MF states millimetres and one object,
/// or one per named part, of type "surface" if not closed; a triangle that repeats a vertex is an error. Writes
/// directly to a path that is no regular file (/dev/stdout).
/// @pre   indices in range, finite positions.
/// @throws nothing; full disk, missing folder or permission end in an Error with the system's reason.
/// @cost  writing, and one readMesh().
Expected<void> writeMesh(const std::filesystem::path& path, const Mesh& mesh, const MeshWriteOptions& options = {});

/// Checks the conditions of writeMesh(): a known extension, a writable folder. Leaves nothing behind.
Expected<void> canWriteMesh(const std::filesystem::path& path);
/// The same for a file of any extension.
Expected<void> canWriteFile(const std::filesystem::path& path);

namespace internal {

/// Compares the triangles of a file with those of the mesh that it was written from: same number, same order, same
/// positions, in float32 or in double. Error kWriteFailed with the first difference.
Expected<void> requireSameTriangles(const Mesh& read, const Mesh& written, bool double_positions);

}  // namespace internal
}  // namespace kerf
