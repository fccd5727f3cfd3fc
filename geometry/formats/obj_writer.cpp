// OBJ writer. Not by OpenMesh 9, which rejects vertex colours ("VertexColor not supported by OBJ Writer") and meshes
// that are not 2-manifold. Numbers are the shortest that restore the float32 exactly, in any locale.
#include <charconv>
#include <ostream>
#include <string>

#include "geometry/formats/mesh_writer.h"

namespace kerf::internal {
namespace {

// An empty name: the following triangles belong to an object without one. A trailing backslash would continue the name
// on the next line.
std::string lineOf(std::string name) {
  while (!name.empty() && (name.back() == '\\' || name.back() == ' ')) name.pop_back();
  return "o " + name + '\n';
}

}  // namespace

Expected<void> writeObj(std::ostream& out, const Mesh& mesh, const MeshWriteOptions& options) {
  const bool colors = options.colors && mesh.hasVertexColors();
  if (!options.comment.empty()) out << "# " << options.comment << '\n';

  char line[256];
  char* const end = line + sizeof line;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    char* p = line;
    *p++ = 'v';
    for (int k = 0; k < 3; ++k) {
      *p++ = ' ';
      p = std::to_chars(p, end, static_cast<float>(mesh.vertices[v][k])).ptr;
    }
    for (std::size_t k = 0; colors && k < 3; ++k) {
      *p++ = ' ';
      p = std::to_chars(p, end, static_cast<float>(mesh.vertex_colors[v][k]) / 255.0f).ptr;
    }
    *p++ = '\n';
    out.write(line, p - line);
  }

  auto part = options.objects.begin();
  for (std::size_t n = 0; n < mesh.triangles.size(); ++n) {
    if (part != options.objects.end() && part->first_triangle == n) {
      if (n > 0 || !part->name.empty()) out << lineOf(part->name);
      ++part;
    }
    char* p = line;
    *p++ = 'f';
    for (const std::uint32_t v : mesh.triangles[n]) {
      *p++ = ' ';
      p = std::to_chars(p, end, std::uint64_t{v} + 1).ptr;
    }
    *p++ = '\n';
    out.write(line, p - line);
  }
  return {};
}

}  // namespace kerf::internal
