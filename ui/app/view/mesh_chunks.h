// Splits a whole mesh into chunks for the live renderer: neighbours, gums, scans and other uncut meshes.
#pragma once

#include <vector>

#include "geometry/mesh/mesh.h"
#include "sim/live/remesher.h"

namespace kerf {

/// A chunk with vertex colours: sRGB, with gloss in place of alpha.
struct ColouredChunk {
  MeshChunk chunk;
  std::vector<Rgba8> colours;
};

/// Sorts triangles by the grid cell of their centroid, each into one chunk. `brick` is the cell, unique to the chunk.
/// Normals are smooth over gentle bends and sharp over creases of 40 degrees and more. A mesh without colours is ivory.
/// O(triangles).
/// @param cell  side of a cell, mm, > 0. A cell with more vertices than a chunk can count (65 536) becomes several
/// chunks; all except the first have a `brick` far away.
std::vector<ColouredChunk> chunksOf(const Mesh& mesh, double cell = 2);

}  // namespace kerf
