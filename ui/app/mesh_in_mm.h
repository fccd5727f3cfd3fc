// A mesh file in mm, whatever its unit, and what the user is to know about that.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/formats/named_part.h"
#include "geometry/mesh/mesh.h"

namespace kerf {

struct MeshInMm {
  Mesh mesh;                         ///< mm; not rounded to float32 where it was scaled
  std::string unit;                  ///< that of the file: chooseUnit()
  std::vector<NamedPart> objects{};  ///< MeshFile::objects
  std::string note;  ///< a sentence if it was scaled, or if the unit is doubtful; empty: mm without a doubt
};

/// @param asked_unit  what the user says it is in; empty: as the file declares, or by its size.
/// Errors: those of readMesh() and chooseUnit(). Any thread.
Expected<MeshInMm> readMeshInMm(const std::filesystem::path& file, const std::string& asked_unit);

}  // namespace kerf
