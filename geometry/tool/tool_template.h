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

/// The same of a tool made of a mesh, of which the file's name and place are to be filled in: readTool() asks for the
/// mesh.   @param mesh  its file's name.
std::string meshToolTemplate(const std::string& mesh, const std::string& id);

}  // namespace kerf
