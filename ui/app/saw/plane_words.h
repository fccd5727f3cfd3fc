// Planes as words of a command line: a normal and a point, three points, or a height over the occlusal plane.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/types.h"
#include "geometry/mesh/mesh.h"

namespace kerf {

/// X,Y,Z: three finite numbers. None: another text.
std::optional<Vec3d> vectorOfWord(std::string_view word);

/// NX,NY,NZ or NX,NY,NZ@PX,PY,PZ.
struct NormalAndPoint {
  Vec3d normal;  ///< as written, of any length but 0
  std::optional<Vec3d> point;
};
/// None: another text, or a normal of length 0.
std::optional<NormalAndPoint> normalAndPointOfWord(std::string_view word);

/// Forms that `planeOfWord()` reads, for help texts.
inline constexpr const char* kPlaneWords = "NX,NY,NZ@X,Y,Z | X,Y,Z/X,Y,Z/X,Y,Z | occlusal@MM";

/// NX,NY,NZ@X,Y,Z: perpendicular to a normal, through a point. X,Y,Z/X,Y,Z/X,Y,Z: through three points,
/// counter-clockwise as seen from the normal's side. occlusal@MM: parallel to the occlusal plane of `mesh`, so much
/// above it.
/// @param option  named in errors.   Errors: kBadValue for another word; kGeometry for points on a line, and without an
/// occlusal plane.   @cost  of `occlusal` about 0.5 s.
Expected<Plane> planeOfWord(const std::string& word, const Mesh& mesh, const std::string& option);

/// X,Y,Z/X,Y,Z: two points. Error kBadValue.
Expected<std::array<Vec3d, 2>> twoPointsOfWord(const std::string& word, const std::string& option);

}  // namespace kerf
