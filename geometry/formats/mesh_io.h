// Reads mesh files: strictly, by content, with errors that name a remedy.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/formats/named_part.h"
#include "geometry/mesh/mesh.h"

namespace kerf {

/// Limit of coordinates in a file, in its own unit; a larger one is an error.
inline constexpr double kLargestCoordinate = 1e8;

struct MeshFile {
  Mesh mesh;  ///< in the file's own unit and frame
  /// Encoding of the file, for display: "binary STL", "ASCII PLY", "OBJ". Readers of one encoding leave it empty, and
  /// readMesh() sets the name of the format.
  std::string_view format;
  /// The coordinates exceed the precision of float32: PLY `double`, or text with more digits than any float32 needs.
  bool had_double_coordinates = false;
  /// "mm", "cm", "m", "um" or "inch" if the file, its header or a comment states it ("units = mm"), else empty.
  std::string declared_unit;
  std::size_t polygons_triangulated = 0;  ///< faces of four or more corners
  std::size_t unwelded_vertices = 0;      ///< STL: corners before welding, three per triangle. Others: 0, no welding
  /// The named objects of OBJ and 3MF, in triangle order; empty if none has a name.
  std::vector<NamedPart> objects{};
  std::vector<std::string> notes;  ///< skipped, ignored or odd content; plain sentences for the user
};

/// Reads every format of the table (mesh_formats.h) that has a reader: STL (binary, ASCII), PLY (ASCII, both binary
/// orders), OFF/COFF/NOFF, 3MF, OBJ. The content decides the format; the extension only words the errors, and a wrong
/// one gets a note.
///
///   STL        a soup: corners with exactly equal coordinates become one vertex, in order of first appearance. Every
///              triangle stays, even a degenerate one, and nothing moves.
///   the others vertex order and count stay exactly as in the file, so labels and colours per vertex still fit.
///   3MF        the objects on the build plate, copies and components at their places, in one mesh; within an
///              object the order stays. The reader flips mirrored copies back, and omits supports.
/// The reader triangulates polygons: a fan if convex, else ear clipping; triangle strips of PLY become triangles.
/// Names: `o` of OBJ, `g` in a file without; `name` of a 3MF object, else that of the object it is a component of.
/// Colours: PLY vertex and face (bytes, shorts, reals), OBJ `v x y z r g b`, COFF vertices, OFF faces, STL attribute
/// words (Magics, VisCAM), 3MF colour groups and base materials (per triangle where a file colours whole triangles,
/// else per vertex). For vertices without colours: textures (JPEG, PNG) of OBJ and PLY become colours of vertices, `Kd`
/// those of faces. Their files lie beside the mesh; a missing one gets a note. Repaired, with a note: a byte order
/// mark, UTF-16, an ASCII STL without "endsolid" or with words after its keywords, a binary STL whose count is 0 or -1
/// or that ends in zeros or blanks, colours that are not finite. Errors, never a partial mesh: missing or unreadable
/// file, no faces (point cloud), truncated or over-long data, coordinates that are not finite, indices out of range,
/// counts the file cannot hold, zip bombs and their like made of 3MF components, 3MF that requires an unknown extension
/// or is older than the standard, 3Shape DCM, other archives, web pages, STEP and other files by their kind. Positions
/// are doubles as the file says; ASCII PLY `float` is rounded to float32 as declared.
/// @cost  one read of the file; memory a small multiple of its size. 200 000 triangles: binary STL 20 ms, PLY 10, OBJ
/// and OFF 35, ASCII STL 190, 3MF 220.
/// @throws nothing.
Expected<MeshFile> readMesh(const std::filesystem::path& path, const Progress& progress = {});

}  // namespace kerf
