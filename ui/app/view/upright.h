// Finds the upper side of a scan. Scanners store jaws in any attitude.
#pragma once

#include <filesystem>
#include <optional>

#include "geometry/mesh/mesh.h"
#include "preprocess/close/dental_arch.h"

namespace kerf {

/// Direction of an open surface's area vector: away from the opening, unit. None: closed, or nearly so.
/// @pre outward; an inside-out scan gives the opposite.   @cost one pass.
std::optional<Vec3d> awayFromOpening(const Mesh& mesh);

/// Unit vector out of the teeth: away from the base, refined by the occlusal plane if there is one. Without a base: the
/// fissured side of a full arch, if the other side is much smoother; else the direction with most cusp tips that
/// protrude from their surroundings. None: none of these.
/// @param solid  closed, mm.   @cost 50 ms for a jaw with a base, six times that and more without one.
std::optional<Vec3d> occlusalNormalOf(const Mesh& solid);

/// The same, and the dental arch, if it is a full one: findDentalArch().
/// @cost  as occlusalNormalOf(), and 20 ms.
struct OcclusalSide {
  std::optional<Vec3d> normal;
  std::optional<DentalArch> arch;
};
OcclusalSide occlusalSideOf(const Mesh& solid);

/// The coordinate axis that is up, by reliable signs only: away from the opening, or from a flat base; of a full arch
/// without either, the fissured side, if the other one is much smoother. None: no such sign, as in a single tooth.
/// @param mesh  mm.   @cost two passes; for a mesh as large as an arch without opening and base, 0.2 to 0.5 s.
std::optional<Vec3d> surelyUp(const Mesh& mesh);

/// The same for the scene of a program: the solid of a case or of a run's case, in which no cut can pass for a base;
/// else the mesh.   @param mesh  of a mesh file, mm.
std::optional<Vec3d> surelyUp(const std::filesystem::path& scene, const Mesh& mesh);

}  // namespace kerf
