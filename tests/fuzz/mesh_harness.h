// Harness of the mesh readers. The buffer has exactly the size of the input, so reads past its end are detected.
#pragma once

#include <algorithm>
#include <cstring>

#include "geometry/formats/mesh_formats.h"
#include "geometry/formats/mesh_source.h"
#include "tests/fuzz/harness.h"

namespace kerf::fuzz {

inline void requireMesh(const MeshFile& file) {
  const Mesh& mesh = file.mesh;
  require(!mesh.triangles.empty(), "a mesh that was read has triangles");
  for (const Triangle& triangle : mesh.triangles)
    for (const std::uint32_t v : triangle) require(v < mesh.vertices.size(), "vertex indices are in range");
  for (const Vec3d& p : mesh.vertices) require(p.allFinite(), "coordinates are finite");
  require(mesh.vertex_colors.empty() || mesh.vertex_colors.size() == mesh.vertices.size(), "one colour per vertex");
  require(mesh.face_colors.empty() || mesh.face_colors.size() == mesh.triangles.size(), "one colour per triangle");
  constexpr const char* kUnits[] = {"", "mm", "cm", "m", "um", "inch"};
  require(std::find(std::begin(kUnits), std::end(kUnits), file.declared_unit) != std::end(kUnits), "a unit we know");
}

inline void requireError(const Error& error) {
  require(!error.file.empty() && !error.place.empty() && !error.found.empty(), "an error says where and what");
  require(error.message().size() < 4096, "an error can be read");
}

/// Follows readMesh(): calls the reader's content check, and may run the reader on rejected content.
/// @param extension  of the format in the table: ".off".
inline void readMeshBytes(const char* extension, const std::uint8_t* data, std::size_t size) {
  if (size == 0) return;  // refused before any reader runs
  const MeshFormatRow& format = *formatOfExtension(extension);
  internal::MeshSource source;
  source.file = std::string("input") + extension;
  source.bytes.reset(new char[size]);
  source.size = size;
  std::memcpy(source.bytes.get(), data, size);
  format.recognise(source);
  const Expected<MeshFile> file = format.read(source, Progress{});
  if (file)
    requireMesh(*file);
  else
    requireError(file.error());
}

}  // namespace kerf::fuzz
