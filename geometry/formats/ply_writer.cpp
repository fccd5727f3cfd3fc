// Binary little-endian PLY. Not by OpenMesh 9: it rounds positions to float32 and writes no comment.
#include <bit>
#include <ostream>

#include "geometry/formats/mesh_writer.h"

namespace kerf::internal {
namespace {

template <class T>
char* put(char* p, T bits) {
  for (std::size_t i = 0; i < sizeof(T); ++i) *p++ = static_cast<char>(bits >> (8 * i));
  return p;
}

char* putColor(char* p, const Rgba8& color) {
  for (const std::uint8_t c : color) *p++ = static_cast<char>(c);
  return p;
}

constexpr const char* kColorProperties =
    "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n";

}  // namespace

Expected<void> writePly(std::ostream& out, const Mesh& mesh, const MeshWriteOptions& options) {
  const bool vertex_colors = options.colors && mesh.hasVertexColors(),
             face_colors = options.colors && mesh.hasFaceColors();
  const char* real = options.double_positions ? "double" : "float";

  out << "ply\nformat binary_little_endian 1.0\n";
  if (!options.comment.empty()) out << "comment " << options.comment << '\n';
  out << "element vertex " << mesh.vertices.size() << '\n';
  for (const char axis : {'x', 'y', 'z'}) out << "property " << real << ' ' << axis << '\n';
  if (vertex_colors) out << kColorProperties;
  if (!options.vertex_quality.empty()) out << "property float quality\n";
  out << "element face " << mesh.triangles.size() << "\nproperty list uchar int vertex_indices\n";
  if (face_colors) out << kColorProperties;
  out << "end_header\n";

  char record[32];
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    char* p = record;
    for (int k = 0; k < 3; ++k)
      p = options.double_positions ? put(p, std::bit_cast<std::uint64_t>(mesh.vertices[v][k]))
                                   : put(p, std::bit_cast<std::uint32_t>(static_cast<float>(mesh.vertices[v][k])));
    if (vertex_colors) p = putColor(p, mesh.vertex_colors[v]);
    if (!options.vertex_quality.empty()) p = put(p, std::bit_cast<std::uint32_t>(options.vertex_quality[v]));
    out.write(record, p - record);
  }

  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    char* p = record;
    *p++ = 3;
    for (const std::uint32_t v : mesh.triangles[t]) p = put(p, v);
    if (face_colors) p = putColor(p, mesh.face_colors[t]);
    out.write(record, p - record);
  }
  return {};
}

}  // namespace kerf::internal
