#include "geometry/mesh/rigid_move.h"

#include "geometry/mesh/self_intersection.h"

namespace kerf {

Expected<Mesh> rigidlyMoved(const Mesh& mesh, const Rigid3& motion) {
  constexpr int kAttempts = 12;
  constexpr double kShift = 1e-5;  // mm
  Mesh out = mesh;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const Vec3d shift = kShift * attempt * Vec3d(0.37, -0.61, 0.70);
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
      out.vertices[v] = roundedToFloat(motion * mesh.vertices[v] + shift);
    if (selfIntersections(out.vertices, out.triangles, 1).empty()) return out;
  }
  return fail({.code = Error::Code::kGeometry,
               .place = "moved mesh",
               .found = "its surface crosses itself at its new position, rounded to single precision",
               .expected = "a surface that can be printed",
               .hint = "turn it by another 0.1 degrees"});
}

}  // namespace kerf
