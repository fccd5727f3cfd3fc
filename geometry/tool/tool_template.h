// Template of a tool file: every key of a head shape, explained, with valid numbers.
#pragma once

#include <string>
#include <string_view>

#include "geometry/tool/blade_motion.h"
#include "geometry/tool/head_shape.h"

namespace kerf {

/// "[0.0, -1.25, 3.0]", to a nanometre of a file in mm: the tip has to be the mesh's lowest point.
std::string tomlVector(const Vec3d& v);

/// "My Bur (2)" as "my-bur-2": an id of the letters, digits and hyphens that a tool file takes. Empty if none is left.
std::string toolIdOf(std::string_view name);

/// TOML that readTool accepts unchanged. Optional keys are comments.
/// @param id  the stem of the file it goes into.
std::string toolTemplate(const HeadShape& shape, const std::string& id);

/// The same for a saw or a disc.
std::string bladeTemplate(const BladeMotion& motion, const std::string& id);

/// Known numbers of a mesh tool; the user fills in the rest.
struct MeshToolNumbers {
  std::string name = "My mesh tool";  ///< without quotes, backslashes and line ends, as `origin`
  std::string origin;                 ///< for a comment: source of the mesh; may be empty
  double mm_per_unit = 1;
  Vec3d tip = Vec3d::Zero();    ///< in the mesh's own coordinates
  Vec3d axis = Vec3d::UnitZ();  ///< from the tip to the shank
  double cut_below_mm = 4;
};
/// The same for a mesh tool: readTool() requires the mesh, and numbers that fit it.
/// @param mesh  its file's name.
std::string meshToolTemplate(const std::string& mesh, const std::string& id, const MeshToolNumbers& numbers = {});

}  // namespace kerf
