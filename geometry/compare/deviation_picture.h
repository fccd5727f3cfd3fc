// Colours and a picture of deviations.
#pragma once

#include <string>
#include <vector>

#include "geometry/compare/comparison.h"

namespace kerf {

/// Colours of deviations, safe for colour-blind readers: grey within the band, below it light to dark blue, above it
/// light to dark red (ColorBrewer RdBu, Harrower & Brewer 2003), dark grey-brown where nothing is known (NaN).
struct DeviationScale {
  double tolerance_mm = 0.1;
  double range_mm = 1;  ///< > tolerance_mm: from here on the darkest colour

  Rgba8 colour(double mm) const;
  /// A round range, 1, 2 or 5 times a power of ten, for 99 % of the area of both; at least twice the band.
  static DeviationScale of(const Comparison& comparison, double tolerance_mm);
};

/// Colours of the vertices by Deviations::at_vertex.
std::vector<Rgba8> vertexColours(const Deviations& deviations, const DeviationScale& scale);

struct DeviationPicture {
  std::string title, subtitle;
  std::vector<std::string> lines;  ///< below the histogram
};

/// An SVG of 1000 px width, which needs nothing else: the mesh in its colours from six sides, drawn in software as an
/// embedded PNG, and the histogram by area over the legend.
/// @param deviations  of `mesh`.   @cost 1 s for 300 000 triangles.   @thread any.
std::string drawDeviations(const Mesh& mesh, const Deviations& deviations, const DeviationScale& scale,
                           const DeviationPicture& picture);

}  // namespace kerf
