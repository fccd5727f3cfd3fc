// Reads a mesh file of any unit in mm, with a note for the user.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/formats/named_part.h"
#include "geometry/mesh/mesh.h"

namespace kerf {

struct MeshInMm {
  Mesh mesh;                         ///< mm; not rounded to float32 if scaled
  std::string unit;                  ///< unit of the file: chooseUnit()
  std::vector<NamedPart> objects{};  ///< MeshFile::objects
  std::string note;                  ///< a sentence if it was scaled or the unit is doubtful; else empty
};

/// @param asked_unit  unit given by the user; empty: as the file declares, or by its size.
/// Errors: those of readMesh() and chooseUnit(). Any thread.
Expected<MeshInMm> readMeshInMm(const std::filesystem::path& file, const std::string& asked_unit);

}  // namespace kerf
