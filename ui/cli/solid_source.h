// The closed solid of a case, a run or a mesh file, for commands that change a solid.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "geometry/base/error.h"
#include "geometry/case/case_bundle.h"
#include "geometry/case/object_names.h"
#include "geometry/mesh/mesh.h"

namespace kerf::cli {

struct SolidSource {
  Mesh solid;                           ///< mm, float32-representable
  std::string name;                     ///< of the folder or file, without its ending
  std::optional<CaseManifest> of_case;  ///< of a case or a run
  ObjectNames names;
  std::string note;  ///< for the user; may be empty
};

/// A case or a run as kerf export writes it, pieces at their scan positions; a mesh file that is ready to print.
/// @param unit  of a mesh file; empty: as declared, or by size.
/// Error kGeometry for a mesh that is no solid, with kerf bake as the remedy.   Shows progress on the terminal.
Expected<SolidSource> readSolid(const std::string& what, const std::string& unit);

/// Rejects overwriting the input: the mesh file itself, or a source of its case.
Expected<void> requireNotInput(const std::string& what, const SolidSource& source, const std::filesystem::path& output);

}  // namespace kerf::cli
