// Synthetic lower arch with the defects of real scans, to test closing and repair.
#pragma once

#include <cstdint>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/mesh/mesh.h"

namespace kerf {

/// Deliberate defects of the scan. The rest is one piece, 2-manifold, not crossing itself.
struct DemoArchDefects {
  std::size_t rims = 1;               ///< one long ragged boundary: the underside is missing
  std::size_t pin_holes = 0;          ///< small boundaries of 3 to 9 edges
  std::size_t islands = 0;            ///< crumbs that float before the surface
  std::size_t island_triangles = 0;   ///< triangles of all islands together
  std::size_t spikes = 0;             ///< single vertices far off
  std::size_t flipped_triangles = 0;  ///< turned inside out, in one patch
  std::size_t flipped_edges = 0;      ///< around that patch
};

struct DemoArch {
  Mesh mesh;  ///< open, mm, z to the occlusal side; teeth ivory, gums pink (vertex colours)
  DemoArchDefects defects;
};

struct DemoArchOptions {
  double edge_mm = 0.25;  ///< mean edge, 0.15 to 1. 0.25 gives about 220 000 triangles
  /// Noise of the surface, root mean square: half of it from vertex to vertex, half in bumps 1.5 mm wide.
  double noise_mm = 0.008;
  std::uint32_t seed = 36;  ///< seed of the noise, the rim and the places of the defects; the same seed gives the same
                            ///< scan
};

/// Teeth 37 to 47 and gums, as an intraoral scanner sees them; frame of demo_jaw.h. Cancelled: kCancelled.
Expected<DemoArch> demoArch(const DemoArchOptions& options = {}, const Progress& progress = {});

}  // namespace kerf
