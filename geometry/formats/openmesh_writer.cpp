// STL and OFF by OpenMesh 9, from float32 positions. OpenMesh accepts or rejects the mesh, and computes the normals.
// This file builds the bytes of STL, a block at a time, because OpenMesh writes each number separately, the slowest
// step. Checked by the round-trip tests: nine significant digits bring every float32 back bit for bit, vertices and
// faces keep their order, OFF keeps the colours of both, the STL header reads "binary stl file".
#include <OpenMesh/Core/IO/MeshIO.hh>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <bit>
#include <cstdint>
#include <sstream>
#include <vector>

#include "geometry/formats/mesh_writer.h"

namespace kerf::internal {
namespace {

static_assert(std::endian::native == std::endian::little, "STL is little endian, and written as it lies in memory");

struct Traits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3f;
  using Normal = OpenMesh::Vec3f;
  using Color = OpenMesh::Vec4uc;
  VertexAttributes(OpenMesh::Attributes::Color);
  FaceAttributes(OpenMesh::Attributes::Color | OpenMesh::Attributes::Normal);
};
using OpenMeshMesh = OpenMesh::TriMesh_ArrayKernelT<Traits>;

OpenMesh::Vec4uc color(const Rgba8& c) { return {c[0], c[1], c[2], c[3]}; }

// Positions and triangles.
Expected<OpenMeshMesh> converted(const Mesh& mesh) {
  // OpenMesh reports to the standard error stream; this file returns an Error instead.
  omlog().disable();
  omout().disable();
  omerr().disable();

  OpenMeshMesh out;
  out.reserve(mesh.vertices.size(), 3 * mesh.triangles.size() / 2, mesh.triangles.size());
  for (const Vec3d& p : mesh.vertices) {
    const Vec3f f = p.cast<float>();
    out.add_vertex({f.x(), f.y(), f.z()});
  }

  using Handle = OpenMeshMesh::VertexHandle;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Triangle& f = mesh.triangles[t];
    const bool repeats = f[0] == f[1] || f[1] == f[2] || f[2] == f[0];
    if (repeats ||
        !out.add_face(Handle(static_cast<int>(f[0])), Handle(static_cast<int>(f[1])), Handle(static_cast<int>(f[2])))
             .is_valid())
      return fail(
          {.code = Error::Code::kGeometry,
           .place = "triangle " + std::to_string(t),
           .found = "it makes the surface non-manifold (an edge of three faces, a flipped or a degenerate face)",
           .expected = "a surface on which every edge has at most two faces",
           .hint = "repair the mesh first, or write PLY or OBJ"});
  }

  return out;
}

void copyColors(const Mesh& mesh, OpenMeshMesh& out) {
  if (mesh.hasVertexColors())
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
      out.set_color(OpenMeshMesh::VertexHandle(static_cast<int>(v)), color(mesh.vertex_colors[v]));
  if (mesh.hasFaceColors())
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      out.set_color(OpenMeshMesh::FaceHandle(static_cast<int>(t)), color(mesh.face_colors[t]));
}

Expected<void> write(std::ostream& stream, const Mesh& mesh, const char* extension,
                     const OpenMesh::IO::Options& options) {
  try {
    KERF_TRY(converted_mesh, converted(mesh));
    copyColors(mesh, converted_mesh);
    constexpr std::streamsize kFloatDigits = 9;  // enough for any float32 to come back exactly
    if (OpenMesh::IO::write_mesh(converted_mesh, stream, extension, options, kFloatDigits)) return {};
    if (!stream) return {};  // the file knows better why
    return fail({.code = Error::Code::kWriteFailed,
                 .place = extension,
                 .found = "OpenMesh could not write the mesh",
                 .hint = "write PLY instead"});
  } catch (const std::exception& e) {
    return fail(
        {.code = Error::Code::kWriteFailed, .place = extension, .found = e.what(), .hint = "write PLY instead"});
  }
}

}  // namespace

Expected<void> writeStl(std::ostream& out, const Mesh& mesh, const MeshWriteOptions&) {
  constexpr std::size_t kHeader = 80, kFacet = 50;  // bytes
  constexpr std::size_t kBlock = 4096;              // facets
  try {
    KERF_TRY(taken, converted(mesh));
    std::string header = "binary stl file";
    header.resize(kHeader - 1, ' ');
    header.push_back('\0');
    const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
    header.append(reinterpret_cast<const char*>(&count), sizeof count);
    out.write(header.data(), static_cast<std::streamsize>(header.size()));

    std::vector<char> bytes;
    bytes.reserve(kBlock * kFacet);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      OpenMesh::Vec3f facet[4];  // normal and corners
      for (std::size_t k = 0; k < 3; ++k)
        facet[k + 1] = taken.point(OpenMeshMesh::VertexHandle(static_cast<int>(mesh.triangles[t][k])));
      facet[0] = taken.OpenMeshMesh::PolyMesh::calc_face_normal(facet[1], facet[2], facet[3]);
      for (const OpenMesh::Vec3f& numbers : facet) {
        const char* const begin = reinterpret_cast<const char*>(numbers.data());
        bytes.insert(bytes.end(), begin, begin + 3 * sizeof(float));
      }
      bytes.insert(bytes.end(), 2, '\0');  // attributes: none

      if (bytes.size() < kBlock * kFacet && t + 1 < mesh.triangles.size()) continue;
      out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
      bytes.clear();
    }
    return {};
  } catch (const std::exception& e) {
    return fail({.code = Error::Code::kWriteFailed, .place = ".stl", .found = e.what(), .hint = "write PLY instead"});
  }
}

Expected<void> writeOff(std::ostream& out, const Mesh& mesh, const MeshWriteOptions& options) {
  OpenMesh::IO::Options write_options;
  if (options.colors && mesh.hasVertexColors()) write_options += OpenMesh::IO::Options::VertexColor;
  if (options.colors && mesh.hasFaceColors()) write_options += OpenMesh::IO::Options::FaceColor;
  if (options.colors) write_options += OpenMesh::IO::Options::ColorAlpha;

  if (!write_options.check(OpenMesh::IO::Options::FaceColor) || write_options.check(OpenMesh::IO::Options::VertexColor))
    return write(out, mesh, ".off", write_options);

  // OpenMesh begins with "COFF" for face colours too, but COFF promises a colour with every vertex.
  std::ostringstream text;
  KERF_CHECK(write(text, mesh, ".off", write_options));
  const std::string bytes = std::move(text).str();
  const std::size_t begin = bytes.starts_with("COFF") ? 1 : 0;
  out.write(bytes.data() + begin, static_cast<std::streamsize>(bytes.size() - begin));
  return {};
}

}  // namespace kerf::internal
