// Which side of a scan is up. Scanners store jaws any way round.
#pragma once

#include <filesystem>
#include <optional>

#include "geometry/mesh/mesh.h"
#include "preprocess/close/dental_arch.h"

namespace kerf {

/// An open surface has an area vector: it points away from where it is open, unit. None: closed, or nearly so.
/// @pre outward; a scan that is inside out gives the opposite.   @cost one pass.
std::optional<Vec3d> awayFromOpening(const Mesh& mesh);

/// Out of the teeth, unit: away from the base, by the occlusal plane if there is one. Without a base it is not known
/// which way is up: of a full arch the side that is furrowed by fissures, if the other one is much smoother; else the
/// direction in which most cusp tips are found that stand out of what is around them. None: none of these.
/// @param solid  closed, mm.   @cost 50 ms for a jaw with a base, six times that and more without one.
std::optional<Vec3d> occlusalNormalOf(const Mesh& solid);

/// The same, and the arch that the teeth stand along, if it is a full one: findDentalArch().
/// @cost  as occlusalNormalOf(), and 20 ms.
struct OcclusalSide {
  std::optional<Vec3d> normal;
  std::optional<DentalArch> arch;
};
OcclusalSide occlusalSideOf(const Mesh& solid);

/// The coordinate axis that is up, by what can not be mistaken: away from the opening, or from a flat base; of a full
/// arch without either, the side that is furrowed by fissures, if the other one is much smoother. None: the mesh tells
/// nothing, as a single tooth.
/// @param mesh  mm.   @cost two passes; without opening and base, of what is as large as an arch, 0.2 to 0.5 s.
std::optional<Vec3d> surelyUp(const Mesh& mesh);

/// The same of what a program is asked to show: of the solid of a case and of a run's case, in which no cut can be
/// taken for a base; else of the mesh.   @param mesh  of a mesh file, mm.
std::optional<Vec3d> surelyUp(const std::filesystem::path& scene, const Mesh& mesh);

}  // namespace kerf
