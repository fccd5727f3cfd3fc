#include "geometry/formats/mesh_formats.h"

#include "geometry/formats/mesh_sinks.h"
#include "geometry/formats/mesh_source.h"

namespace kerf {

std::span<const MeshFormatRow> meshFormats() {
  using namespace internal;
  // Asked in this order: the size of a binary STL is the surest sign, a line of words beginning with "v" the weakest.
  static constexpr MeshFormatRow kFormats[] = {
      {"STL", ".stl", "triangles without colour or unit; binary and ASCII in, binary out", isStl, readStl, writeStl},
      {"PLY", ".ply", "vertex and face colours, float or double; ASCII and binary in, binary out", isPly, readPly,
       writePly},
      {"OFF", ".off .coff .noff", "ASCII, vertex and face colours", isOff, readOff, writeOff},
      {"3MF", ".3mf", "unit, face or vertex colours; several objects are read into one mesh", isThreeMf, readThreeMf,
       writeThreeMf},
      {"OBJ", ".obj", "polygons, vertex colours; materials are not read", isObj, readObj, writeObj},
  };
  return kFormats;
}

const MeshFormatRow* formatOfExtension(std::string_view extension) {
  for (const MeshFormatRow& row : meshFormats()) {
    internal::Words words(row.extensions);
    for (std::string_view e = words.next(); !e.empty(); e = words.next())
      if (internal::equalsIgnoringCase(extension, e)) return &row;
  }
  return nullptr;
}

namespace {
std::string extensionsIf(bool (*wanted)(const MeshFormatRow&)) {
  std::string list;
  for (const MeshFormatRow& row : meshFormats())
    if (wanted(row)) list += (list.empty() ? "" : ", ") + std::string(internal::Words(row.extensions).next());
  return list;
}
}  // namespace

std::string readableExtensions() {
  return extensionsIf([](const MeshFormatRow& row) { return row.read != nullptr; });
}
std::string writableExtensions() {
  return extensionsIf([](const MeshFormatRow& row) { return row.write != nullptr; });
}

}  // namespace kerf
