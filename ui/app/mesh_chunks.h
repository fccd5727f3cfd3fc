// A whole mesh in the chunks that the live renderer takes: neighbours, gums, scans, what is not cut.
#pragma once

#include <vector>

#include "geometry/mesh/mesh.h"
#include "sim/live/remesher.h"

namespace kerf {

/// A chunk with the colours of its vertices: sRGB, in the place of alpha the gloss.
struct ColouredChunk {
  MeshChunk chunk;
  std::vector<Rgba8> colours;
};

/// The triangles of the mesh by the cell of a grid that their middle lies in: every triangle in one chunk. `brick` is
/// the cell; no two chunks have the same. Normals are smooth over gentle bends and sharp over creases of 40 degrees and
/// more. A mesh without colours is ivory. O(triangles).
/// @param cell  side of a cell, mm, > 0. A cell with more vertices than a chunk can count (65 536) becomes several
/// chunks; all but the first have a `brick` far away.
std::vector<ColouredChunk> chunksOf(const Mesh& mesh, double cell = 2);

}  // namespace kerf
