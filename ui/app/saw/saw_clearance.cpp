#include "ui/app/saw/saw_clearance.h"

#include <algorithm>
#include <cmath>

namespace kerf {

SawClearance clearanceOf(const SawPlane& plane, double kerf_mm, const Structures& structures) {
  constexpr double kStep = 0.25, kRounding = 1e-4;  // mm
  const int columns = static_cast<int>(std::ceil(plane.width / kStep));
  const int rows = static_cast<int>(std::ceil(plane.depth / kStep));

  SawClearance out{Material::kNone, structures.reach(), true};
  for (const Structures::Structure& structure : structures.all())
    for (int row = 0; row <= rows; ++row)
      for (int column = 0; column <= columns; ++column) {
        const double u = (static_cast<double>(column) / columns - 0.5) * plane.width;
        const double v = static_cast<double>(row) / rows * plane.depth;
        const double to_plane = static_cast<double>(structure.field->distance(plane.fromPlane(u, v).cast<float>()));
        if (to_plane < out.distance_mm - kRounding) out = {structure.material, to_plane, false};
      }
  out.distance_mm -= 0.5 * kerf_mm;
  return out;
}

}  // namespace kerf
