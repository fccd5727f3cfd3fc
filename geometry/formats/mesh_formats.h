// The list of mesh file formats. A new one is one source in geometry/internal and one line in mesh_formats.cpp.
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

struct MeshFormatRow {
  std::string_view name;         ///< "STL"
  std::string_view extensions;   ///< ".stl", lower case, separated by blanks; the first is the usual one
  std::string_view description;  ///< one line for help texts
  bool (*recognise)(const internal::MeshSource&);  ///< by content; null if the format is only written
  Expected<MeshFile> (*read)(const internal::MeshSource&, const Progress&);      ///< null: not read
  Expected<void> (*write)(std::ostream&, const Mesh&, const MeshWriteOptions&);  ///< null: not written
};

std::span<const MeshFormatRow> meshFormats();
/// The row whose extensions contain `extension` (any case, with the dot), or nullptr.
const MeshFormatRow* formatOfExtension(std::string_view extension);
/// ".stl, .ply, .obj, .off" of the formats that can be read or written.
std::string readableExtensions();
std::string writableExtensions();

}  // namespace kerf
