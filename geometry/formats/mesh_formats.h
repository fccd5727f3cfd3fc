// The table of mesh file formats: one row a format. Reading, writing, messages and help texts go by it.
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

/// Whether the content is of the format. Sees the whole file; must not fail.
using MeshRecogniser = bool(const internal::MeshSource& source);
/// Reads what was recognised, or what only bears the format's extension: then the error says what is missing.
using MeshReader = Expected<MeshFile>(const internal::MeshSource& source, const Progress& progress);
/// Writes to a stream that the caller checks and closes. The comment in `options` has no line ends, the names are
/// clean.
using MeshWriter = Expected<void>(std::ostream& out, const Mesh& mesh, const MeshWriteOptions& options);

struct MeshFormatRow {
  std::string_view name;        ///< as said to users: "STL"
  std::string_view extensions;  ///< ".off .coff": lower case, separated by blanks, the usual one first
  /// What a file can hold beside triangles.
  struct Carries {
    bool vertex_colors = false, face_colors = false;
    bool object_names = false;
    bool unit = false;     ///< says its unit in a place made for it; a comment that says so does not count
    bool doubles = false;  ///< can be written with double positions; the others hold float32
  } carries{};
  MeshRecogniser* recognise = nullptr;  ///< null: not read
  MeshReader* read = nullptr;           ///< null: not read
  MeshWriter* write = nullptr;          ///< null: not written
};

/// All formats, in the order in which their recognisers are asked.
std::span<const MeshFormatRow> meshFormats();
/// The row whose extensions contain `extension` (any case, with the dot), or nullptr.
const MeshFormatRow* formatOfExtension(std::string_view extension);

/// The usual extensions of the formats that can be read: ".stl, .ply, .off".
std::string readableExtensions();
std::string writableExtensions();
/// The names of the formats for help texts: "STL, PLY or OFF".
std::string readableFormats();
std::string writableFormats();
/// The same of those that are written with colours.
std::string colorFormats();

}  // namespace kerf
