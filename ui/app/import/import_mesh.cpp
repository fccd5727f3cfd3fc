#include "ui/app/import/import_mesh.h"

#include <cstdint>
#include <utility>

namespace kerf {
namespace {

constexpr Rgba8 kScanColour = {233, 221, 197, 255};
constexpr Rgba8 kInsideColour = {150, 138, 132, 255};  // hollow underside of an open scan

// Gives each face a colour: joined meshes need all or none.
void colourFaces(Mesh& mesh) {
  if (mesh.hasFaceColors()) return;
  mesh.face_colors.assign(mesh.triangles.size(), kScanColour);
  for (std::size_t t = 0; mesh.hasVertexColors() && t < mesh.triangles.size(); ++t)
    mesh.face_colors[t] = mesh.vertex_colors[mesh.triangles[t][0]];
  mesh.vertex_colors.clear();
}

// Halfway to a bluish grey.
void makePale(Mesh& mesh) {
  constexpr Rgba8 kPale = {150, 165, 185, 255};
  for (Rgba8& colour : mesh.face_colors)
    for (std::size_t n = 0; n < 3; ++n)
      colour[n] = static_cast<std::uint8_t>((static_cast<int>(colour[n]) + static_cast<int>(kPale[n])) / 2);
}

// Adds the inside as reversed triangles, because the renderer draws front faces only.
Mesh withInside(Mesh mesh) {
  Mesh inside = mesh;
  for (Triangle& t : inside.triangles) std::swap(t[1], t[2]);
  inside.vertex_colors.clear();
  inside.face_colors.assign(inside.triangles.size(), kInsideColour);
  colourFaces(mesh);
  append(mesh, inside);
  return mesh;
}

}  // namespace

Mesh meshOf(const ImportPicture& picture) {
  Mesh all;
  for (const ImportPicture::Part& part : picture.parts) {
    Mesh shown = *part.mesh;
    for (Vec3d& p : shown.vertices) p *= part.scale_to_mm;
    if (part.is_open) shown = withInside(std::move(shown));
    if (part.is_beside || picture.parts.size() > 1) colourFaces(shown);
    if (part.is_beside) makePale(shown);

    const bool is_first = all.triangles.empty();
    if (is_first)
      all = std::move(shown);
    else
      append(all, shown);
  }
  return all;
}

}  // namespace kerf
