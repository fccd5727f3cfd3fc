// The closed solid of a case, a run or a mesh file, for commands that change a solid.
#pragma once

#include <filesystem>
#include <string>

#include "geometry/base/error.h"
#include "geometry/case/object_names.h"
#include "geometry/mesh/mesh.h"

namespace kerf::cli {

struct SolidSource {
  Mesh solid;        ///< mm, float32-representable
  std::string name;  ///< of the folder or file, without its ending
  ObjectNames names;
  std::string note;  ///< for the user; may be empty
};

/// A case or a run as kerf export writes it, pieces at their scan positions; a mesh file that is ready to print.
/// @param unit  of a mesh file; empty: as declared, or by size.
/// Error kGeometry for a mesh that is no solid, with kerf bake as the remedy.   Shows progress on the terminal.
Expected<SolidSource> readSolid(const std::string& what, const std::string& unit);

/// Rejects an output that would overwrite an input: the mesh file itself; a source of a case, of a run's case or of its
/// neighbours, by its bytes; a file in the folder of an input.
/// @param input  case, run or mesh file.   Error kBadValue; those of an unreadable run.   @cost  reads the old output.
Expected<void> requireNotInput(const std::filesystem::path& input, const std::filesystem::path& output);

}  // namespace kerf::cli
