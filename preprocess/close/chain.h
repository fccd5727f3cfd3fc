// The working mesh of closeMesh(): triangles as a 2-chain, and its boundary. The winding number needs only a closed
// chain (every directed edge met by its opposite as often), no manifold.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/mesh/mesh.h"
#include "preprocess/close/edges.h"
#include "preprocess/unit/source_triangle.h"

namespace kerf {
struct CloseOptions;
struct CloseReport;
enum class CloseStep;
}  // namespace kerf

namespace kerf::internal {

struct Chain {
  Mesh mesh;                          ///< float32 coordinates, no two vertices equal
  std::vector<std::uint32_t> source;  ///< per triangle: imported triangle or kAdded
  std::uint32_t source_vertices = 0;  ///< vertices below this index come from the import, in its order
  int handles = 0;                    ///< handlesOf() the import, before its boundary was closed
  double open_mm = 0;  ///< openLength() of the import, welded and stitched, before any of its triangles was dropped

  std::uint32_t addVertex(const Vec3d& p);
  void addTriangle(std::uint32_t a, std::uint32_t b, std::uint32_t c);
};

/// Colour of the surface that closing adds to a coloured mesh: light model stone.
inline constexpr Rgba8 kNeutral = {214, 205, 189, 255};

/// Place of a vertex; closing welds vertices at one place. Near zero float32 distinguishes points 1e-45 mm apart. For
/// example, the pole of a sphere with points R sin(pi), 1e-16, is 24 vertices, a hole for every later step. So a
/// coordinate below a hundredth of an atom becomes zero.
Vec3d weldPlace(const Vec3d& p);

/// True if some edge is not met by its opposite as often.
bool hasBoundary(const Chain& chain);

/// Rounds, welds, drops triangles that repeat a vertex and duplicates, stitches, orients, drops open crumbs.
/// Enters everything in the report. Errors: kGeometry if a step is needed that CloseOptions::only leaves out.
Expected<Chain> buildChain(const Mesh& imported, const CloseOptions& options, CloseReport& report);

/// Keeps the triangles with keep[t] != 0.
void keepOnly(Chain& chain, const std::vector<char>& keep);

/// The error for a mesh that needs a step which CloseOptions::only leaves out.
Error missingStep(std::string found, CloseStep step, const CloseOptions& options);

/// "3 holes", "1 hole".
std::string counted(std::size_t n, const char* singular, const char* plural);

}  // namespace kerf::internal
