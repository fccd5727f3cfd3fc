// The table of mesh file formats, one row each, used by readers, writers, messages and help texts.
//
// A new format is one source with the functions of its row, and the row (mesh_formats.cpp); see CONTRIBUTING.md.
#pragma once

#include <iosfwd>
#include <span>
#include <string>
#include <string_view>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/formats/mesh_io.h"
#include "geometry/formats/mesh_writer.h"

namespace kerf {
namespace internal {
struct MeshSource;
}

/// True if the content has the format. Sees the whole file; must not fail.
using MeshRecogniser = bool(const internal::MeshSource& source);
/// Reads a recognised file, or one with only the format's extension: then the error names the missing part.
using MeshReader = Expected<MeshFile>(const internal::MeshSource& source, const Progress& progress);
/// Writes to a stream; the caller checks and closes it. The comment in `options` has no line ends, the names are clean.
using MeshWriter = Expected<void>(std::ostream& out, const Mesh& mesh, const MeshWriteOptions& options);

struct MeshFormatRow {
  std::string_view name;        ///< display name: "STL"
  std::string_view extensions;  ///< ".off .coff": lower case, separated by blanks, the usual one first
  /// Contents of a file beside triangles.
  struct Carries {
    bool vertex_colors = false, face_colors = false;
    bool object_names = false;
    bool unit = false;     ///< states its unit in a field of the format; a comment does not count
    bool doubles = false;  ///< has double positions; other formats hold float32
  } carries{};
  MeshRecogniser* recognise = nullptr;  ///< null: not read
  MeshReader* read = nullptr;           ///< null: not read
  MeshWriter* write = nullptr;          ///< null: not written
};

/// All formats, in the order of their recognisers' calls.
std::span<const MeshFormatRow> meshFormats();
/// The row whose extensions contain `extension` (any case, with the dot), or nullptr.
const MeshFormatRow* formatOfExtension(std::string_view extension);

/// The usual extensions of the readable formats: ".stl, .ply, .off".
std::string readableExtensions();
std::string writableExtensions();
/// The names of the formats for help texts: "STL, PLY or OFF".
std::string readableFormats();
std::string writableFormats();
/// The same for formats written with colours.
std::string colorFormats();

}  // namespace kerf
