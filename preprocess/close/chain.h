// The working mesh of closeMesh(): triangles as a 2-chain, and its boundary. A closed chain (every directed edge met by
// its opposite as often) is all that the winding number needs; it need not be a manifold.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/mesh/mesh.h"
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

  std::uint32_t addVertex(const Vec3d& p);
  void addTriangle(std::uint32_t a, std::uint32_t b, std::uint32_t c);
};

/// What closing adds to a coloured mesh: light model stone.
inline constexpr Rgba8 kNeutral = {214, 205, 189, 255};

/// An undirected edge a < b and how often the chain runs along it from a to b (forth) and back.
struct EdgeCount {
  std::uint32_t a, b;
  int forth, back;
};
/// All edges, sorted by (a, b). Cost: one sort.
std::vector<EdgeCount> countEdges(const std::vector<Triangle>& triangles);

/// A closed walk along the chain's boundary, in the direction the missing faces would use; no vertex twice.
using Loop = std::vector<std::uint32_t>;
std::vector<Loop> boundaryLoops(const std::vector<Triangle>& triangles);
bool hasBoundary(const Chain& chain);

/// Rounds, welds, drops triangles that repeat a vertex and duplicates, stitches, orients, drops open crumbs.
/// Everything is entered in the report. Errors: kGeometry if a step is needed that CloseOptions::only leaves out.
Expected<Chain> buildChain(const Mesh& imported, const CloseOptions& options, CloseReport& report);

/// Turns pieces that are inside out, unless they are the wall of a cavity in something else. @pre the chain is closed.
/// @return true if the box of one piece lies in that of another: their winding numbers must be looked at.
bool turnPieces(Chain& chain, CloseReport& report);

/// True if every edge has one triangle on each side and the triangles at every vertex form one fan.
bool isClosedManifold(const Mesh& mesh);

/// The error for a mesh that needs a step which CloseOptions::only leaves out.
Error missingStep(std::string found, CloseStep step, const CloseOptions& options);

/// "3 holes", "1 hole".
std::string counted(std::size_t n, const char* singular, const char* plural);

}  // namespace kerf::internal
