// A tool file to start from: every key of a head shape, explained, with numbers that make a tool.
#pragma once

#include <string>

#include "geometry/tool/blade_motion.h"
#include "geometry/tool/head_shape.h"

namespace kerf {

/// TOML that readTool accepts as it is. Optional keys are there as comments.
/// @param id  the stem of the file it goes into.
std::string toolTemplate(const HeadShape& shape, const std::string& id);

/// The same of a saw or a disc.
std::string bladeTemplate(const BladeMotion& motion, const std::string& id);

/// What is known of a mesh that becomes a tool; else a person fills it in.
struct MeshToolNumbers {
  std::string name = "My mesh tool";  ///< without quotes, backslashes and line ends, as `origin`
  std::string origin;                 ///< for a comment: where the mesh comes from; may be empty
  double mm_per_unit = 1;
  Vec3d tip = Vec3d::Zero();    ///< in the mesh's own coordinates
  Vec3d axis = Vec3d::UnitZ();  ///< from the tip to the shank
  double cut_below_mm = 4;
};
/// The same of a tool made of a mesh: readTool() asks for the mesh, and whether its numbers fit it.
/// @param mesh  its file's name.
std::string meshToolTemplate(const std::string& mesh, const std::string& id, const MeshToolNumbers& numbers = {});

}  // namespace kerf
